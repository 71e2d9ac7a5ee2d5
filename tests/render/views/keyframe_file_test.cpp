// A keyframe in a file: its small values and every picture come back, and what is no keyframe's is told.
#include "render/views/keyframe_file.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "tests/contracts/expect.h"
#include "tests/support/scratch_folder.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

constexpr SectionFormat kFormat{.what = "a box of keyframes",
                                .magic = {'k', 'e', 'y', 's', '\n', 0, 0, 0},
                                .version = 1,
                                .mend = "write it again"};
constexpr int kRows = 3, kCols = 4;

// Values of one picture alone, rising from `first`.
Image<float> rising(int channels, float first) {
  Image<float> picture(channels, kRows, kCols);
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.samples()[i] = first + static_cast<float>(i) / 1024;
  return picture;
}

// The first of a file, without motion.
Keyframe first_keyframe() {
  Keyframe key;
  key.frame.radiance = rising(3, 2), key.frame.sigma = rising(1, 3), key.inverse_depth = rising(1, 4);
  key.frame.provenance = Image<std::uint8_t>(1, kRows, kCols);
  for (std::size_t i = 0; i < key.frame.provenance.size(); ++i)
    key.frame.provenance.samples()[i] = static_cast<std::uint8_t>(i % kProvenances);
  return key;
}

Keyframe later_keyframe() {
  Keyframe key = first_keyframe();
  key.to_previous = {rising(2, -7), rising(1, 0.25f)};
  key.from_previous = {rising(2, 6), rising(1, 0.75f)};
  return key;
}

// Writes the pictures and reads them again, as those of a file of this many rows.
Result<Keyframe> through_file(const std::string& name, const Keyframe& key, int rows = kRows) {
  const std::string path = test::scratch_folder("keyframe_file_" + name) + "/box";
  SectionWriter writer =
      value_of(SectionWriter::create(value_of(FileInMaking::beside(posix_storage(), path)), kFormat));
  require_done(save_pictures(key, writer));
  require_done(writer.finish());
  SectionReader reader = value_of(SectionReader::open(posix_storage(), path, kFormat));
  Keyframe read;
  TRY(load_pictures(reader, rows, kCols, read));
  require_done(reader.end_of_file());
  return read;
}

bool same(const auto& a, const auto& b) {
  return a.same_shape(b) && std::ranges::equal(a.samples(), b.samples());
}

void check_same_pictures(const Keyframe& is, const Keyframe& was) {
  CHECK(same(is.frame.radiance, was.frame.radiance));
  CHECK(same(is.frame.sigma, was.frame.sigma));
  CHECK(same(is.frame.provenance, was.frame.provenance));
  CHECK(same(is.inverse_depth, was.inverse_depth));
  CHECK(same(is.to_previous.vectors, was.to_previous.vectors));
  CHECK(same(is.to_previous.confidence, was.to_previous.confidence));
  CHECK(same(is.from_previous.vectors, was.from_previous.vectors));
  CHECK(same(is.from_previous.confidence, was.from_previous.confidence));
}

}  // namespace

TEST_CASE("every picture of a keyframe comes back from its file to the bit, its motion both ways") {
  const Keyframe later = later_keyframe();
  check_same_pictures(value_of(through_file("later", later)), later);
}

TEST_CASE("a keyframe without motion comes back without it") {
  const Keyframe first = first_keyframe(), read = value_of(through_file("first", first));
  check_same_pictures(read, first);
  CHECK(read.knows_depth);
  CHECK(read.to_previous.empty());
  CHECK(read.from_previous.empty());
}

TEST_CASE("a keyframe that knows no depth comes back as one that knows none") {
  Keyframe was = first_keyframe();
  was.inverse_depth.fill(0.7f), was.knows_depth = false;
  CHECK_FALSE(value_of(through_file("unknown_depth", was)).knows_depth);
}

TEST_CASE("the small values of a keyframe come back, with its pose, its lens and the facts of its frame") {
  const RigidTransform T_world_camera(rotation(Eigen::Vector3d(0.1, 0.2, 0.3)), Eigen::Vector3d(4, 5, 6));
  Keyframe was;
  was.time_s = 12.5, was.world = 2, was.depth_unit = 0.75f;
  was.T_world_camera = T_world_camera, was.lens = {50, 51, 24, 16};
  was.frame.facts.sequence = 9, was.frame.facts.exposure_s = 0.004;
  was.frame.exposure = 0.5f, was.frame.reference_exposure = 0.008, was.frame.white = 3;
  was.frame.white_balance = ChannelGains{2, 1, 1.5};
  was.frame.pose = FramePose{T_world_camera.inverse(), PoseSource::Tracked, true, 2};
  was.frame.length_unit = LengthUnit::FirstDepth;
  was.frame.lens = Intrinsics{60, 61, 25, 17}, was.frame.lens_is_assumed = true;
  FieldsOut out;
  out(was);
  FieldsIn in(out.bytes());
  Keyframe is;
  in(is);
  REQUIRE(in.complete());
  CHECK(is.time_s == 12.5);
  CHECK(is.world == 2);
  CHECK(is.depth_unit == 0.75f);
  CHECK(is.T_world_camera == T_world_camera);
  CHECK(is.lens.fy_px == 51);
  CHECK(is.frame.facts.sequence == 9);
  CHECK(is.frame.facts.exposure_s == 0.004);
  CHECK(is.frame.exposure == 0.5f);
  CHECK(is.frame.reference_exposure == 0.008);
  CHECK(is.frame.white == 3);
  CHECK(is.frame.white_balance == was.frame.white_balance);
  REQUIRE(is.frame.pose);
  CHECK(is.frame.pose->T_world_camera == T_world_camera.inverse());
  CHECK(is.frame.pose->source == PoseSource::Tracked);
  CHECK(is.frame.pose->lost);
  CHECK(is.frame.pose->world == 2);
  CHECK(is.frame.length_unit == LengthUnit::FirstDepth);
  REQUIRE(is.frame.lens);
  CHECK(is.frame.lens->cx_px == 25);
  CHECK(is.frame.lens_is_assumed);
}

TEST_CASE("pictures of another size are not taken for a keyframe's") {
  for (const int rows : {kRows - 1, kRows + 1}) {
    CAPTURE(rows);
    const auto read = through_file("size", later_keyframe(), rows);
    require_error(read, ErrorCode::Corrupt);
    CHECK_THAT(read.error().message, Contains("it is not as large as its pictures"));
  }
}

TEST_CASE("a value that no picture has is told in each picture of a keyframe") {
  constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
  const std::function<void(Keyframe&)> faults[] = {
      [](Keyframe& key) { key.frame.radiance.at(2, 1, 3) = -1; },
      [=](Keyframe& key) { key.frame.radiance.at(2, 1, 3) = kNoNumber; },
      [=](Keyframe& key) { key.frame.sigma.at(0, 1, 3) = kNoNumber; },
      [](Keyframe& key) { key.frame.provenance.at(0, 1, 3) = kProvenances; },
      [](Keyframe& key) { key.inverse_depth.at(0, 1, 3) = 0; },
      [=](Keyframe& key) { key.to_previous.vectors.at(1, 1, 3) = kNoNumber; },
      [](Keyframe& key) { key.to_previous.confidence.at(0, 1, 3) = 1.5f; },
      [](Keyframe& key) { key.from_previous.vectors.at(1, 1, 3) = 1e9f; },
      [](Keyframe& key) { key.from_previous.confidence.at(0, 1, 3) = -0.5f; }};
  for (const auto& fault : faults) {
    CAPTURE(&fault - faults);
    Keyframe key = later_keyframe();
    fault(key);
    const auto read = through_file("fault", key);
    require_error(read, ErrorCode::Corrupt);
    CHECK_THAT(read.error().message, Contains("it holds a value that no picture has"));
  }
}
