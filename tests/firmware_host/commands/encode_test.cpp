// hdrcam encode, and videos instead of numbered frames, from outside.
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include "firmware_host/exit_code.h"
#include "hal/forwarding_storage.h"
#include "render/exr.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/decoded_video.h"
#include "tests/support/ran.h"
#include "tests/support/ran_here.h"

#include "tests/support/as_nobody.h"

using namespace hdrcam;
using Catch::Contains;
using test::ran_here;
using test::RanHere;

namespace {

const std::string kDemo = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";

// What the program writes to its standard output, and its exit code.
std::pair<std::string, int> piped(const std::string& words) {
  std::FILE* const pipe = ::popen(("'" HDRCAM_BINARY "' " + words + " 2>/dev/null").c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string bytes;
  char block[1 << 16];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) bytes.append(block, n);
  return {bytes, ::pclose(pipe)};
}

test::DecodedVideo codes_of(const std::string& bytes, const std::string& path) {
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(bytes))).ok());
  return test::decoded_video(path);
}

// An OpenEXR file of grey, [1, rows, cols].
void write_grey(const std::string& path, const Image<float>& grey, const ExrAttributes& attributes = {}) {
  ExrPicture picture{grey.rows(), grey.cols(), {}, attributes, ExrCompression::None};
  for (const std::string_view channel : exr_channel::kRadiance)
    picture.channels.push_back({std::string(channel), grey.samples(), ExrSample::Float});
  REQUIRE(write_whole(posix_storage(), path, encode_exr(picture).value()).ok());
}

// The disk of a program that is told to stop while it reads a file for the second time, for its picture after
// its time.
class StoppedWhileReading : public ForwardingStorage {
 public:
  explicit StoppedWhileReading(std::string path)
      : ForwardingStorage(posix_storage()), path_(std::move(path)) {}

  Result<std::unique_ptr<StorageFile>> open(const std::string& path) override {
    if (path == path_ && ++times_ == 2) stop_ = true;
    return ForwardingStorage::open(path);
  }
  const std::atomic<bool>& stop() const { return stop_; }
  int times() const { return times_; }

 private:
  const std::string path_;
  int times_ = 0;
  std::atomic<bool> stop_{false};
};

int largest_difference(const Image<std::uint16_t>& a, const Image<std::uint16_t>& b) {
  REQUIRE(a.same_shape(b));
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(int{a.samples()[i]} - int{b.samples()[i]}));
  return largest;
}

}  // namespace

TEST_CASE("a replay writes a video, frames beside it, and encode makes the same of the frames") {
  const std::string out = sample::scratch_folder("encode");
  const RanHere replayed = ran_here({"replay", kDemo, "--preset", "fast", "--emit", "state", "--frames", "7",
                                     "-o", out + "/%06d.exr", "--video", out + "/replayed.mp4"});
  INFO(replayed.err);
  REQUIRE(replayed.exit_code == 0);
  const RanHere encoded = ran_here({"encode", out + "/%06d.exr", "-o", out + "/encoded.mp4"});
  INFO(encoded.err);
  REQUIRE(encoded.exit_code == 0);
  const auto [again, again_code] = piped("encode " + out + "/%06d.exr --force -o " + out + "/encoded.mp4");
  CHECK(again_code == 0);
  CHECK_THAT(again, Contains(out + "/encoded.mp4: 7 frames"));
  const auto a = test::decoded_video(out + "/replayed.mp4"), b = test::decoded_video(out + "/encoded.mp4");
  REQUIRE(a.frames.size() == 7);
  REQUIRE(b.frames.size() == 7);
  CHECK(a.light->MaxCLL > 0);
  CHECK(std::abs(static_cast<int>(a.light->MaxCLL) - static_cast<int>(b.light->MaxCLL)) <= 1);  // half floats
  for (std::size_t i = 0; i < 7; ++i) CHECK(a.frames[i].time_s == Approx(b.frames[i].time_s).margin(1e-6));
  // Before the codec, but for the rounding of half floats.
  const auto [replayed_codes, replay_code] =
      piped("replay '" + kDemo + "' --preset fast --emit state --frames 7 -o - --pipe-format y4m");
  const auto [encoded_codes, encode_code] = piped("encode " + out + "/%06d.exr -o - --pipe-format y4m");
  CHECK(replay_code == 0);
  CHECK(encode_code == 0);
  const auto x = codes_of(replayed_codes, out + "/x.y4m"), y = codes_of(encoded_codes, out + "/y.y4m");
  REQUIRE(x.frames.size() == 7);
  REQUIRE(y.frames.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) CHECK(largest_difference(x.frames[i].luma, y.frames[i].luma) <= 1);
}

TEST_CASE("an earlier video stays unless it is to be replaced") {
  const std::string out = sample::scratch_folder("encode_kept");
  const std::string path = out + "/x.mp4", text = "an earlier take";
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  const std::vector<std::string> words{"replay", kDemo,      "--preset", "fast", "--emit",
                                       "state",  "--frames", "6",        "-o",   path};
  const RanHere kept = ran_here(words);
  CHECK(kept.exit_code == 17);
  CHECK_THAT(kept.err, Contains(path) && Contains("--force"));
  CHECK(read_whole(posix_storage(), path).value() == text);
  std::vector<std::string> forced = words;
  forced.push_back("--force");
  CHECK(ran_here(forced).exit_code == 0);
  CHECK(test::decoded_video(path).frames.size() == 6);
}

TEST_CASE("a video that is stopped holds the frames before it, and encode says how many") {
  const std::string out = sample::scratch_folder("encode_stopped"), path = out + "/x.mp4";
  for (const char* name : {"/000000.exr", "/000001.exr", "/000002.exr"})
    write_grey(out + name, Image<float>(1, 48, 64));
  StoppedWhileReading storage(out + "/000001.exr");
  const RanHere stopped = ran_here({"encode", out + "/%06d.exr", "-o", path}, storage, storage.stop());
  INFO(stopped.err);
  CHECK(stopped.exit_code == kExitInterrupted);
  CHECK_THAT(stopped.err, Contains("stopped after 2 of 3 frames; they are complete"));
  CHECK(test::decoded_video(path).frames.size() == 2);

  StoppedWhileReading unread(out + "/000002.exr");
  const RanHere at_once = ran_here({"encode", out + "/%06d.exr", "-o", out + "/y.mp4"}, unread, true);
  CHECK(at_once.exit_code == kExitInterrupted);
  CHECK(unread.times() == 0);
  CHECK_THAT(at_once.err, Contains("stopped before the first frame"));
  CHECK_FALSE(std::filesystem::exists(out + "/y.mp4"));
}

TEST_CASE("frames go to a pipe, and nothing but frames") {
  const std::string out = sample::scratch_folder("encode_pipe");
  const std::string replay =
      "replay '" + kDemo + "' --preset fast --emit state --frames 6 -o - --pipe-format ";
  const auto [y4m, y4m_code] = piped(replay + "y4m");
  CHECK(y4m_code == 0);
  CHECK(y4m.starts_with("YUV4MPEG2 "));
  const auto video = codes_of(y4m, out + "/x.y4m");
  CHECK(video.frames.size() == 6);
  const auto [half, half_code] = piped(replay + "half");
  CHECK(half_code == 0);
  CHECK(half.size() == std::size_t{6} * 3 * 2 * static_cast<std::size_t>(video.width * video.height));
}

TEST_CASE("a frame of another size ends a pipe before it, as nothing in bare radiance tells sizes") {
  const std::string out = sample::scratch_folder("encode_sizes");
  write_grey(out + "/000000.exr", Image<float>(1, 48, 64));
  write_grey(out + "/000001.exr", Image<float>(1, 32, 64));
  for (const char* format : {"half", "nut", "y4m"}) {
    INFO(format);
    const auto [bytes, status] = piped("encode " + out + "/%06d.exr -o - --pipe-format " + format);
    CHECK(WEXITSTATUS(status) == exit_code_of(ErrorCode::SizeChanged));
    if (format == std::string_view("half")) CHECK(bytes.size() == std::size_t{48} * 64 * 3 * 2);
  }
}

TEST_CASE("a frame of another size is named with the first one, both with their sizes") {
  const std::string out = sample::scratch_folder("encode_named_sizes");
  write_grey(out + "/000007.exr", Image<float>(1, 48, 64));
  write_grey(out + "/000009.exr", Image<float>(1, 32, 64));
  const RanHere refused = ran_here({"encode", out + "/%06d.exr", "-o", out + "/x.mp4"});
  CHECK(refused.exit_code == exit_code_of(ErrorCode::SizeChanged));
  CHECK_THAT(refused.err, Contains("'" + out + "/000009.exr' has 64x32 pixels, and '" + out +
                                   "/000007.exr', the first frame, 64x48; give frames of one size"));
}

TEST_CASE("a frame rate that cannot be is refused, naming the file and --framerate, which overrules it") {
  const std::string out = sample::scratch_folder("encode_framerate"), frames = out + "/%06d.exr";
  const double framerate_hz = GENERATE(0.0, -30.0, 5000.0, std::numeric_limits<double>::quiet_NaN());
  ExrAttributes stated;
  stated.framerate_hz = framerate_hz;
  write_grey(out + "/000000.exr", Image<float>(1, 48, 64), stated);
  const RanHere refused = ran_here({"encode", frames, "-o", out + "/x.mp4"});
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.err,
             Contains("000000.exr' states ") && Contains(" frames per second") && Contains("--framerate"));
  if (std::isnan(framerate_hz)) CHECK_THAT(refused.err, Contains("states 0/0 frames per second"));
  const RanHere given = ran_here({"encode", frames, "-o", out + "/x.mp4", "--framerate", "25"});
  INFO(given.err);
  CHECK(given.exit_code == 0);
}

TEST_CASE("frames that state their times keep them and their rate, whatever --framerate says") {
  const std::string out = sample::scratch_folder("encode_own_rate"), timed = out + "/%06d.exr",
                    untimed = out + "/untimed_%06d.exr";
  for (int i = 0; i < 3; ++i) {
    ExrAttributes attributes;
    attributes.framerate_hz = 30;
    write_grey(fmt::format("{}/untimed_{:06d}.exr", out, i), Image<float>(1, 16, 16), attributes);
    attributes.texts["hdrcam.secondsSinceStart"] = fmt::format("{}", i / 30.);
    write_grey(fmt::format("{}/{:06d}.exr", out, i), Image<float>(1, 16, 16), attributes);
  }
  const auto y4m = [](const std::string& frames) {
    return piped("encode " + frames + " -o - --pipe-format y4m --framerate 60").first;
  };
  CHECK_THAT(y4m(timed).substr(0, 40), Contains(" F30:1 "));
  CHECK_THAT(y4m(untimed).substr(0, 40), Contains(" F60:1 "));
  const auto told = [&](const std::string& frames, const std::string& rate_hz) {
    const test::Ran run =
        test::ran({"encode", frames, "-o", out + "/x.mp4", "--force", "--framerate", rate_hz});
    CHECK(run.exit_code == 0);
    return run.output;
  };
  CHECK_THAT(told(timed, "60"), Contains("note: the files state their times, and --framerate is for files"));
  CHECK_THAT(told(timed, "30"), !Contains("note:"));
  CHECK_THAT(told(untimed, "60"), !Contains("note:"));
}

TEST_CASE("encode warns of a pause as long as numbers of nanoseconds make it, and of no frame that is lost") {
  const std::string out = sample::scratch_folder("encode_pause");
  const auto told = [&](const std::string& name, const std::vector<std::string>& numbers) {
    for (const std::string& number : numbers)
      write_grey(fmt::format("{}/{}_{}.exr", out, name, number), Image<float>(1, 16, 16));
    const test::Ran run = test::ran(
        std::vector<std::string>{"encode", fmt::format("{}/{}_%0{}d.exr", out, name, numbers[0].size()), "-o",
                                 out + "/" + name + ".mkv"});
    CHECK(run.exit_code == 0);
    return run.output;
  };
  CHECK_THAT(told("stamps", {"1716900000000000000", "1716900000033333333", "1716900000066666666"}),
             Contains("stamps_1716900000033333333.exr' comes 1111111 s after the frame before it"));
  CHECK_THAT(told("apart", {"0000000000000000001", "9000000000000000000"}),
             Contains("' comes 4000000000 s after"));
  CHECK_THAT(told("lost", {"000000", "000001", "000150"}), !Contains("warning"));
}

TEST_CASE("encode warns of primaries that it does not convert, and not of its own") {
  const std::string out = sample::scratch_folder("encode_primaries"), frames = out + "/%06d.exr";
  ExrAttributes attributes;
  for (const bool wide : {false, true}) {
    attributes.chromaticities = Chromaticities{};
    if (wide) attributes.chromaticities->green = {0.170f, 0.797f};  // BT.2020
    write_grey(out + "/000000.exr", Image<float>(1, 64, 64), attributes);
    const test::Ran encoded = test::ran({"encode", frames, "-o", out + "/x.mp4", "--force"});
    CHECK(encoded.exit_code == 0);
    CHECK((encoded.output.find("000000.exr' states other primaries") != std::string::npos) == wide);
  }
}

TEST_CASE("radiance 1 is as bright as the file states, unless --white says otherwise") {
  const std::string out = sample::scratch_folder("encode_white"), plain = out + "/plain_%06d.exr",
                    stating = out + "/stating_%06d.exr";
  Image<float> grey(1, 32, 32);
  grey.fill(1);
  write_grey(out + "/plain_000000.exr", grey);
  ExrAttributes attributes;
  attributes.white_cd_m2 = 100;
  write_grey(out + "/stating_000000.exr", grey, attributes);
  const auto code = [&](const std::string& words) {
    const auto [y4m, status] = piped("encode " + words + " -o - --pipe-format y4m");
    CHECK(status == 0);
    const test::DecodedVideo video = codes_of(y4m, out + "/x.y4m");
    REQUIRE(video.frames.size() == 1);
    return int{video.frames[0].luma.at(0, 16, 16)};
  };
  const int usual = code(plain), stated = code(stating);
  CHECK(stated < usual);
  CHECK(stated == code(plain + " --white 100"));
  CHECK(code(stating + " --white 203") == usual);
  CHECK(code(stating + " --transfer sdr") == code(plain + " --transfer sdr"));
}

TEST_CASE("a luminance of radiance 1 that cannot be is refused, and one that changes is warned of") {
  const std::string out = sample::scratch_folder("encode_white_refused"), frames = out + "/%06d.exr";
  const Image<float> grey(1, 48, 64);
  ExrAttributes attributes;
  for (const double white_nits : {0.0, 2000.0, std::numeric_limits<double>::quiet_NaN()}) {
    CAPTURE(white_nits);
    attributes.white_cd_m2 = white_nits;
    write_grey(out + "/000000.exr", grey, attributes);
    const RanHere refused = ran_here({"encode", frames, "-o", out + "/x.mp4", "--force"});
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.err, Contains("000000.exr' states") && Contains("--peak") && Contains("--white"));
    CHECK(ran_here({"encode", frames, "-o", out + "/x.mp4", "--force", "--white", "203"}).exit_code == 0);
  }
  int number = 0;
  for (const double white_nits : {100.0, 100.0, 80.0, 90.0}) {
    attributes.white_cd_m2 = white_nits;
    write_grey(fmt::format("{}/{:06d}.exr", out, number++), grey, attributes);
  }
  const std::string told = test::ran({"encode", frames, "-o", out + "/x.mp4", "--force"}).output;
  CHECK_THAT(told, Contains("000002.exr' states another luminance") && !Contains("000003.exr"));
}

TEST_CASE("a pixel of infinite light is as bright as can be, one that is no number is black") {
  const std::string out = sample::scratch_folder("encode_infinite");
  // Our own writer refuses such values: they replace others in the file.
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const std::pair<float, float> replaced[] = {
      {1.2345f, kInfinite}, {2.3456f, -kInfinite}, {3.4567f, std::numeric_limits<float>::quiet_NaN()}};
  const float greys[] = {1.2345f, 2.3456f, 3.4567f, 6e4f, 0};
  Image<float> picture(1, 32, 5 * 32);
  for (int y = 0; y < picture.rows(); ++y)
    for (int x = 0; x < picture.cols(); ++x) picture.at(0, y, x) = greys[x / 32];
  const std::string path = out + "/000000.exr";
  write_grey(path, picture);
  std::string bytes = read_whole(posix_storage(), path).value();
  for (const auto& [from, to] : replaced) {
    const auto pattern = std::bit_cast<std::array<char, 4>>(from),
               value = std::bit_cast<std::array<char, 4>>(to);
    const std::string_view wanted(pattern.data(), pattern.size());
    for (std::size_t at = 0; (at = bytes.find(wanted, at)) != bytes.npos; at += 4)
      std::ranges::copy(value, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(bytes))).ok());
  const auto [y4m, code] = piped("encode " + out + "/%06d.exr -o - --pipe-format y4m");
  CHECK(code == 0);
  const auto video = codes_of(y4m, out + "/x.y4m");
  REQUIRE(video.frames.size() == 1);
  const auto luma = [&](int patch) { return int{video.frames[0].luma.at(0, 16, 32 * patch + 16)}; };
  CHECK(luma(0) == luma(3));
  CHECK(luma(0) > 600);
  CHECK((luma(1) == luma(4) && luma(2) == luma(4)));
  CHECK(luma(4) < 100);
}

TEST_CASE("encode does not call a folder that it may not list one without frames") {
  const std::string folder = sample::scratch_folder("encode_closed");
  write_grey(folder + "/000000.exr", Image<float>(1, 16, 16));
  std::filesystem::permissions(folder, std::filesystem::perms(0333));
  {
    const test::AsNobody nobody;
    const RanHere refused = ran_here({"encode", folder + "/%06d.exr", "-o", folder + "/x.mp4"});
    CHECK(refused.exit_code == exit_code_of(ErrorCode::Permission));
    CHECK_THAT(refused.err, Contains("cannot read the folder '" + folder + "'"));
  }
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
}

TEST_CASE("encode says what is missing") {
  const std::string out = sample::scratch_folder("encode_missing");
  const RanHere none = ran_here({"encode", out + "/%06d.exr", "-o", out + "/x.mp4"});
  CHECK(none.exit_code == 3);
  CHECK_THAT(none.err, Contains("no frames"));
  const RanHere name = ran_here({"encode", out + "/%06d.exr", "-o", out + "/x.avi"});
  CHECK(name.exit_code == 2);
  CHECK_THAT(name.err, Contains("x.avi") && Contains(".mp4"));
  const RanHere nowhere = ran_here({"encode", out + "/%06d.exr"});
  CHECK(nowhere.exit_code == 2);
  CHECK_THAT(nowhere.err, Contains("no video; give -o x.mp4"));
}

TEST_CASE(
    "encode refuses what contradicts itself before it looks for frames, and its help promises no more") {
  const std::string out = sample::scratch_folder("encode_refused");
  for (const auto& [flags, word] : {std::pair(std::vector<std::string>{"--codec", "h264"}, "--codec h264"),
                                    {{"--peak", "100"}, "--peak 100"}}) {
    std::vector<std::string> words{"encode", out + "/%06d.exr", "-o", out + "/x.mp4"};
    words.insert(words.end(), flags.begin(), flags.end());
    const RanHere refused = ran_here(words);
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.err, Contains(word) && !Contains("no frames"));
  }
  const std::string help = ran_here({"encode", "--help"}).out;
  CHECK_THAT(help, !Contains("Camera:") && !Contains("none") && Contains("0: as they state it, or 30") &&
                       Contains("the video: out.mp4"));
}

TEST_CASE("a frame that cannot be read is an error and no progress") {
  const std::string out = sample::scratch_folder("encode_unread");
  REQUIRE(write_whole(posix_storage(), out + "/1.exr", std::as_bytes(std::span("no picture"))).ok());
  const test::Ran ended = test::ran({"encode", out + "/%01d.exr", "-o", out + "/x.mp4"});
  CHECK(ended.exit_code != 0);
  CHECK_THAT(ended.output, Contains("1.exr' is not an OpenEXR picture") && !Contains("frame 1/1"));
}

TEST_CASE("encode leads from a folder, and from one of its files, to the pattern of the frames") {
  const std::string out = sample::scratch_folder("encode_folder");
  for (const auto& [frames, what] : {std::pair(out, "is a folder"), std::pair(out + "/", "is a folder"),
                                     std::pair(out + "/000001.exr", "names one file")}) {
    const RanHere refused = ran_here({"encode", frames, "-o", out + "/x.mp4"});
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.err, Contains("'" + frames + "' " + what +
                                     "; name the frames by their pattern, such as '" + out + "/%06d.exr'"));
  }
}

TEST_CASE("encode leads from other names to the frames that are there, and from a recording to replay") {
  const std::string out = sample::scratch_folder("encode_names");
  write_grey(out + "/take_000007.exr", Image<float>(1, 16, 16));
  const auto told = [&](const std::vector<std::string>& frames) {
    std::vector<std::string> words{"encode", "-o", out + "/x.mp4"};
    words.insert(words.end(), frames.begin(), frames.end());
    const RanHere refused = ran_here(words);
    CHECK(refused.exit_code != 0);
    return refused.err;
  };
  CHECK_THAT(told({out + "/%04d.exr"}), Contains("there are no frames") &&
                                            Contains("there is '" + out + "/take_000007.exr'") &&
                                            Contains("write '" + out + "/take_%06d.exr'"));
  for (const char* name : {"/f10.exr", "/f9.exr", "/f11.exr", "/f100.exr"})
    write_grey(out + name, Image<float>(1, 16, 16));
  CHECK_THAT(told({out + "/%04d.exr"}),
             Contains("there is '" + out + "/f9.exr'") && Contains("write '" + out + "/f%01d.exr'"));
  CHECK_THAT(told({out + "/f%d.exr"}), Contains("not a frame number like '%06d'") &&
                                           Contains("there is '" + out + "/f9.exr'") &&
                                           Contains("write '" + out + "/f%01d.exr'"));
  CHECK_THAT(told({out}),
             Contains("is a folder; name the frames by their pattern, such as '" + out + "/f%01d.exr'"));
  CHECK_THAT(told({out + "/000001.exr", out + "/000002.exr"}),
             Contains("unexpected argument") && Contains("one pattern, such as 'out/%06d.exr'"));
  CHECK_THAT(told({"walk.mkv"}), Contains("'hdrcam replay' makes a video"));
}

TEST_CASE("encode leads to the frames of a folder whose name has a percent sign") {
  const std::string out = sample::scratch_folder("encode_percent") + "/50%x";
  REQUIRE(posix_storage().make_directories(out).ok());
  write_grey(out + "/f0001.exr", Image<float>(1, 16, 16));
  const RanHere refused = ran_here({"encode", out, "-o", out + "/x.mp4"});
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.err, Contains("'" + out + "' is a folder; name the frames by their pattern, such as '" +
                                   out + "/f%04d.exr'"));
}

TEST_CASE("encode leads to no pattern that it would refuse") {
  const std::string out = sample::scratch_folder("encode_no_pattern");
  for (const char* name : {"/50%_0001.exr", "/00000000000000000001.exr", "/last.exr"})
    write_grey(out + name, Image<float>(1, 16, 16));
  const RanHere folder = ran_here({"encode", out, "-o", out + "/x.mp4"});
  CHECK_THAT(folder.err, Contains("such as '" + out + "/%06d.exr'"));
  const RanHere none = ran_here({"encode", out + "/%06d.exr", "-o", out + "/x.mp4"});
  CHECK(none.exit_code == 3);
  CHECK_THAT(none.err, Contains("there are no frames") && !Contains("for which write"));
}

TEST_CASE("encode refuses flags that its output does not use, and leaves what a file of settings says") {
  const std::string out = sample::scratch_folder("encode_ignored"), frames = out + "/%06d.exr";
  const RanHere piped = ran_here({"encode", frames, "-o", "-", "--codec", "av1", "--crf", "20"});
  CHECK(piped.exit_code == 2);
  CHECK_THAT(piped.err, Contains("compresses no video; give -o out.mp4, or leave out --codec, --crf"));
  const RanHere coarse = ran_here({"encode", frames, "-o", out + "/x.mp4", "--crf", "60"});
  CHECK(coarse.exit_code == 2);
  CHECK_THAT(coarse.err, Contains("beyond what hevc takes"));
  const RanHere filed = ran_here({"encode", frames, "-o", out + "/x.mp4", "--pipe-format", "y4m"});
  CHECK(filed.exit_code == 2);
  CHECK_THAT(filed.err, Contains("give -o -, or leave out --pipe-format"));

  const std::string config = out + "/live.toml",
                    text = "[camera]\nid = \"replay:walk.mkv\"\n[video]\npipe_format = \"y4m\"\n";
  REQUIRE(write_whole(posix_storage(), config, std::as_bytes(std::span(text))).ok());
  const RanHere none =
      ran_here({"encode", frames, "-o", out + "/x.mp4", "--framerate", "25", "--config", config});
  CHECK(none.exit_code == 3);
  CHECK_THAT(none.err, Contains("there are no frames"));
}

TEST_CASE("frames whose time does not go on are of two takes, and no video is made of both") {
  const std::string folder = sample::scratch_folder("encode_joined");
  const Image<float> grey(1, 16, 16);
  for (int i = 0; i < 6; ++i) {
    ExrAttributes attributes;
    attributes.framerate_hz = 30;
    write_grey(fmt::format("{}/untimed_{:04d}.exr", folder, i), grey, attributes);
    attributes.texts["hdrcam.secondsSinceStart"] = fmt::format("{}", i % 3 / 30.);
    write_grey(fmt::format("{}/{:04d}.exr", folder, i), grey, attributes);
  }
  const RanHere joined = ran_here({"encode", folder + "/%04d.exr", "-o", folder + "/joined.mp4"});
  CHECK(joined.exit_code == exit_code_of(ErrorCode::Invalid));
  CHECK_THAT(joined.err, Contains("0003.exr' is not later than") && Contains("0002.exr' before it"));
  CHECK_FALSE(std::filesystem::exists(folder + "/joined.mp4"));
  CHECK(ran_here({"encode", folder + "/untimed_%04d.exr", "-o", folder + "/untimed.mp4"}).exit_code == 0);
}
