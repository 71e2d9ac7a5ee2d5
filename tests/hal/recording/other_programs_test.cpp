// Recordings as other programs write them again: other clusters, other tracks.
#include <optional>
#include <random>
#include <utility>

#include "hal/recording/recording.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::write_file;

namespace {

struct Recorded {
  explicit Recorded(const std::string& name) : path(sample::scratch_folder(name) + "/x.mkv") {
    const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 7, 5);
    frames = sample::frames(camera, 4, 21);
    require_done(sample::record(posix_storage(), path, camera, frames));
  }

  std::string path;
  std::vector<RawFrame> frames;
};

// The bytes of a cluster: its head with checksum and time, the block of the picture, which the end record
// lacks, and the group of the facts.
struct ClusterBytes {
  std::string head, picture, facts;
};

// The clusters that begin at this byte, and where they end.
std::pair<std::vector<ClusterBytes>, std::size_t> clusters_from(const std::string& bytes, std::size_t begin) {
  const auto byte = [&](std::size_t at) { return std::size_t{static_cast<std::uint8_t>(bytes[at])}; };
  // Behind an element with an identifier of one byte, or where its content begins; sizes of up to two bytes.
  const auto content = [&](std::size_t at) { return at + (byte(at + 1) >= 0x80 ? 2 : 3); };
  const auto behind = [&](std::size_t at) {
    return content(at) +
           (byte(at + 1) >= 0x80 ? byte(at + 1) & 0x7f : (byte(at + 1) & 0x3f) << 8 | byte(at + 2));
  };
  std::vector<ClusterBytes> clusters;
  std::size_t at = begin;
  while (bytes.compare(at, 4, "\x1f\x43\xb6\x75") == 0) {
    const std::size_t end = behind(at + 3), first = behind(behind(content(at + 3)));
    const std::size_t facts = bytes[first] == '\xa3' ? behind(first) : first;
    clusters.push_back(
        {bytes.substr(at, first - at), bytes.substr(first, facts - first), bytes.substr(facts, end - facts)});
    at = end;
  }
  return {std::move(clusters), at};
}

// All frames in one cluster. What follows stays in its place.
std::string in_one_cluster(const std::vector<ClusterBytes>& clusters, std::size_t length) {
  std::string blocks("\xe7\x81\0", 3);
  for (const ClusterBytes& cluster : clusters) blocks += cluster.picture + cluster.facts;
  std::string joined("\x1f\x43\xb6\x75\x01");
  for (int shift = 48; shift >= 0; shift -= 8)
    joined += static_cast<char>((std::uint64_t{blocks.size()} >> shift) & 0xffu);
  joined += blocks;
  const std::size_t left = length - joined.size();
  REQUIRE((left >= 2 && left < 0x7f));
  joined += '\xec';  // Void
  joined += static_cast<char>(0x80 | (left - 2));
  return joined + std::string(left - 2, '\0');
}

// The facts of each picture behind the head of the next cluster; all clusters of unknown size.
std::string with_facts_in_next_cluster(const std::vector<ClusterBytes>& clusters) {
  std::string straddled, facts;
  for (const ClusterBytes& cluster : clusters) {
    std::string head = cluster.head;
    if (static_cast<std::uint8_t>(head[4]) >= 0x80)
      head[4] = '\xff';
    else
      head.replace(4, 2, "\x7f\xff");
    straddled += head + facts + cluster.picture;
    facts = cluster.facts;
  }
  return straddled + facts;
}

// All frames are read but this one, and the end is found.
void check_all_but(std::optional<std::size_t> lost, const Recorded& made) {
  const auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped).value();
  for (std::size_t place = 0; place < made.frames.size(); ++place) {
    if (place == lost) continue;
    const auto frame = value_of(reader->next());
    REQUIRE(frame);
    CHECK(sample::same(*frame, made.frames[place]));
  }
  CHECK_FALSE(value_of(reader->next()));
  CHECK(reader->left_out().places ==
        (lost ? std::vector<std::uint64_t>{*lost} : std::vector<std::uint64_t>{}));
  CHECK_FALSE(reader->left_out().end_is_missing);
}

}  // namespace

TEST_CASE("damage costs no other frame, however another program put the frames into clusters") {
  const Recorded made("clusters");
  const std::string bytes = test::text_of(made.path);
  const std::size_t begin = bytes.find("\x1f\x43\xb6\x75");
  const auto [clusters, end] = clusters_from(bytes, begin);
  REQUIRE(clusters.size() == made.frames.size() + 1);
  const bool in_one = GENERATE(false, true);
  CAPTURE(in_one);
  const std::string laid_out =
      bytes.substr(0, begin) +
      (in_one ? in_one_cluster(clusters, end - begin) : with_facts_in_next_cluster(clusters)) +
      bytes.substr(end);
  REQUIRE(laid_out.size() == bytes.size());
  write_file(made.path, laid_out);
  REQUIRE(sample::replay(posix_storage(), made.path).frames.size() == made.frames.size());
  const std::size_t damaged = GENERATE(range(std::size_t{0}, std::size_t{4}));
  CAPTURE(damaged);
  std::string flipped = laid_out;
  const std::string& picture = clusters[damaged].picture;
  flipped[flipped.find(picture) + picture.size() / 2] ^= 1;
  write_file(made.path, flipped);
  check_all_but(damaged, made);
}

TEST_CASE("bytes put into a cluster of many frames cost no frame but the one that they are in") {
  const Recorded made("inserted");
  const std::string bytes = test::text_of(made.path);
  const std::size_t begin = bytes.find("\x1f\x43\xb6\x75");
  const auto [clusters, end] = clusters_from(bytes, begin);
  REQUIRE(clusters.size() == made.frames.size() + 1);
  std::string spread = bytes.substr(0, begin) + in_one_cluster(clusters, end - begin) + bytes.substr(end);
  const std::size_t place = GENERATE(range(std::size_t{0}, std::size_t{5}));  // the last: of the end record
  const bool within = GENERATE(false, true);
  CAPTURE(place, within);
  if (within && place == made.frames.size()) return;
  std::mt19937 random(7);
  std::string other(200, '\0');
  for (char& byte : other) byte = static_cast<char>(random());
  const std::string& picture = clusters[place].picture;
  spread.insert(spread.find(picture + clusters[place].facts) + (within ? picture.size() / 2 : 0), other);
  write_file(made.path, spread);
  check_all_but(within ? std::optional(place) : std::nullopt, made);
}

TEST_CASE("a recording whose tracks another program put in another order lacks none, and the error says so") {
  const Recorded made("tracks");
  std::string bytes = test::text_of(made.path);
  const std::string entry("\xae\x01\0\0\0\0\0\0", 8);  // of a track, with a size below 256
  const auto end_of = [&](std::size_t at) { return at + 9 + static_cast<std::uint8_t>(bytes[at + 8]); };
  const std::size_t pixels = bytes.find(entry), facts = end_of(pixels);
  REQUIRE(bytes.compare(facts, entry.size(), entry) == 0);
  std::string swapped = bytes;
  swapped.replace(pixels, end_of(facts) - pixels,
                  bytes.substr(facts, end_of(facts) - facts) + bytes.substr(pixels, facts - pixels));
  write_file(made.path, swapped);
  const auto replayed = sample::replay(posix_storage(), made.path);
  REQUIRE(replayed.ended_with(ErrorCode::Corrupt));
  CHECK(replayed.error->message.find("in another order") != std::string::npos);
  CHECK(replayed.error->message.find("-map 0:v:0 -map 0:s:0 -c copy") != std::string::npos);

  const std::size_t type = bytes.rfind('\x11', end_of(facts));
  REQUIRE(bytes.compare(type - 2, 2, "\x83\x81") == 0);
  bytes[type] = '\x02';  // sound
  write_file(made.path, bytes);
  CHECK(sample::replay(posix_storage(), made.path).error->message.find("lacks its track") !=
        std::string::npos);
}
