#include "firmware_host/sinks/exr_sequence.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using sample::scratch_folder;
using test::emit;
using test::example_frame;
using test::With;

namespace {

float value_in(const ExrImage& image, std::string_view channel, int y, int x) {
  const auto index = image.find(channel);
  REQUIRE(index.has_value());
  return image.samples.at(*index, y, x);
}

}  // namespace

TEST_CASE("each frame becomes one EXR, numbered by the sensor's sequence, with radiance in half") {
  const std::string folder = scratch_folder("exr");
  auto sink = create_exr_sequence(posix_storage(), folder + "/new/%04d.exr", {.framerate_hz = 25.0});
  REQUIRE(sink.ok());
  const HdrFrame frame = example_frame(41);
  REQUIRE(emit(*sink.value(), frame).ok());
  REQUIRE(emit(*sink.value(), example_frame(43)).ok());
  REQUIRE(sink.value()->finish().ok());

  CHECK(std::filesystem::exists(folder + "/new/0043.exr"));
  CHECK(sample::unfinished_files_in(folder + "/new") == 0);
  const auto read = read_exr(posix_storage(), folder + "/new/0041.exr");
  REQUIRE(read.ok());
  const ExrImage& image = read.value();
  CHECK(image.names == std::vector<std::string>{"B", "G", "R"});
  const float half_precision = 0x1p-11f;
  CHECK(value_in(image, "R", 3, 30) == Approx(frame.radiance.at(0, 3, 30)).epsilon(half_precision));
  CHECK(value_in(image, "G", 3, 30) == Approx(frame.radiance.at(1, 3, 30)).epsilon(half_precision));
  CHECK(value_in(image, "B", 3, 30) == Approx(frame.radiance.at(2, 3, 30)).epsilon(half_precision));

  const ExrAttributes& facts = image.attributes;
  CHECK(*facts.exposure_s == Approx(0.004));
  CHECK(facts.texts.at("hdrcam.gain") == "2");
  CHECK(*facts.framerate_hz == Approx(25));
  CHECK(*facts.chromaticities == Chromaticities{});
  CHECK(*facts.time_code == TimeCode{0, 0, 0, 0});
  CHECK_FALSE(facts.white_cd_m2.has_value());
  CHECK_THAT(facts.comments, Contains("hdrcam") && Contains("frame 41"));
  CHECK_THAT(facts.comments, Contains("the reference exposure 0.032 s at gain 1; this frame's exposure is") &&
                                 Contains(" times that"));
  const auto second = read_exr(posix_storage(), folder + "/new/0043.exr");
  CHECK(*second.value().attributes.time_code == TimeCode{0, 0, 0, 2});
}

TEST_CASE("a file says of an estimated exposure that it is one, and states no time that nobody knows") {
  const std::string folder = scratch_folder("exr-estimated");
  auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr", {});
  REQUIRE(sink.ok());
  HdrFrame frame = example_frame(1);
  frame.facts.exposure_source = ExposureSource::Estimated, frame.facts.verdict = Verdict::Estimated;
  frame.white_balance = ChannelGains{2, 1, 1.5};
  REQUIRE(emit(*sink.value(), frame).ok());
  const auto read = read_exr(posix_storage(), folder + "/0001.exr");
  REQUIRE(read.ok());
  const ExrAttributes& facts = read.value().attributes;
  CHECK(facts.texts.at("hdrcam.exposureSource") == "estimated");
  CHECK(facts.texts.at("hdrcam.exposureVerdict") == "estimated");
  CHECK(facts.texts.at("hdrcam.whiteBalance") == "2, 1, 1.5");
  CHECK_FALSE(facts.exposure_s);
  CHECK_THAT(facts.comments, Contains("estimated: no time is known"));
}

TEST_CASE("a file states the pose of its one camera, and none where two eyes see side by side") {
  const std::string folder = scratch_folder("exr-pose");
  auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr", {});
  REQUIRE(sink.ok());
  HdrFrame frame = example_frame(1);
  frame.pose = FramePose{{Eigen::Matrix3d::Identity(), {1, 2, 3}}, PoseSource::Tracked};
  frame.lens = Intrinsics{32, 32, 16, 12};
  REQUIRE(emit(*sink.value(), frame).ok());
  frame.facts.sequence = 2;
  frame.lens.reset();
  REQUIRE(emit(*sink.value(), frame).ok());
  const auto one = read_exr(posix_storage(), folder + "/0001.exr"),
             stereo = read_exr(posix_storage(), folder + "/0002.exr");
  REQUIRE((one.ok() && stereo.ok()));
  REQUIRE(one.value().attributes.T_world_camera);
  CHECK((*one.value().attributes.T_world_camera)[3] == Approx(1));
  CHECK(one.value().attributes.texts.contains("hdrcam.poseSource"));
  CHECK_FALSE(stereo.value().attributes.T_world_camera);
  CHECK_FALSE(stereo.value().attributes.texts.contains("hdrcam.poseSource"));
}

TEST_CASE("a film's frame states the moment of the recording that it shows, and a recorded frame none") {
  const std::string folder = scratch_folder("exr-moment");
  auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr", {});
  REQUIRE(sink.ok());
  REQUIRE(emit(*sink.value(), example_frame(1)).ok());
  HdrFrame frame = example_frame(2);
  frame.recorded_s = 0.25;
  REQUIRE(emit(*sink.value(), frame).ok());
  const auto texts_of = [&](const char* file) {
    const auto read = read_exr(posix_storage(), folder + file);
    REQUIRE(read.ok());
    return read.value().attributes.texts;
  };
  CHECK_FALSE(texts_of("/0001.exr").contains(kExrRecordedSeconds));
  CHECK(texts_of("/0002.exr").at("hdrcam.secondsInRecording") == "0.250000000");
}

TEST_CASE("the layers that were asked for are in the file, and no others") {
  const std::string folder = scratch_folder("exr-layers");
  const ExrLayers all{.depth = true,
                      .flow = true,
                      .flow_forward = true,
                      .field_flow = true,
                      .field_flow_forward = true,
                      .confidence = true,
                      .provenance = true};
  for (const auto compression : {ExrCompression::Rle, ExrCompression::Zip, ExrCompression::Piz}) {
    auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr",
                                    {.layers = all, .compression = compression});
    REQUIRE(sink.ok());
    REQUIRE(emit(*sink.value(), example_frame(1, With::DepthAndFlow)).ok());
    const auto read = read_exr(posix_storage(), folder + "/0001.exr");
    REQUIRE(read.ok());
    CHECK(read.value().names.size() == 3 + 1 + 2 + 2 + 2 + 2 + 2 + 1);
    CHECK(value_in(read.value(), "Z", 6, 0) == 7);
    CHECK(value_in(read.value(), "backward.u", 2, 2) == 0.5f);
    CHECK(value_in(read.value(), "backward.v", 2, 2) == -1.5f);
    CHECK(value_in(read.value(), "forward.v", 2, 2) == 1.0f / 3);  // float: half would round it
    CHECK(value_in(read.value(), "field.v", 2, 2) == 0.25f);
    CHECK(value_in(read.value(), "field.forward.u", 2, 2) == -0.25f);
    CHECK(value_in(read.value(), "sigma", 9, 0) == Approx(0.1f).epsilon(1e-3));
    CHECK(value_in(read.value(), "confidence", 9, 0) == Approx(std::exp(-0.1f)).epsilon(1e-3));
    CHECK(value_in(read.value(), "provenance", 0, 31) == 4);
    const auto& units = read.value().attributes.texts;
    for (const char* layer :
         {"RGB", "Z", "backward", "forward", "field", "field.forward", "sigma", "confidence", "provenance"})
      CHECK(units.contains(std::string("hdrcam.unit.") + layer));
    CHECK_THAT(units.at("hdrcam.unit.Z"), Contains("unit: median depth of the first view"));
    CHECK_THAT(units.at("hdrcam.unit.provenance"), Contains("0 own sample") && Contains("4 clipped bound"));
  }
}

TEST_CASE("a frame without depth or motion has zeros in those layers, so that the channels never change") {
  const std::string folder = scratch_folder("exr-zeros");
  auto sink =
      create_exr_sequence(posix_storage(), folder + "/%04d.exr", {.layers = {.depth = true, .flow = true}});
  REQUIRE(emit(*sink.value(), example_frame(0)).ok());
  const auto read = read_exr(posix_storage(), folder + "/0000.exr");
  REQUIRE(read.ok());
  CHECK(value_in(read.value(), "Z", 5, 5) == 0);
  CHECK(value_in(read.value(), "backward.u", 5, 5) == 0);
}

TEST_CASE("a full disk ends the sequence with an error and leaves only whole files") {
  const std::string folder = scratch_folder("exr-full");
  FaultyStorage full(posix_storage(), test::disk_of(6000));
  auto sink = create_exr_sequence(full, folder + "/%04d.exr", {});
  REQUIRE(sink.ok());
  std::uint64_t written = 0;
  Result<void> last;
  for (std::uint64_t sequence = 0; last.ok() && sequence < 100; ++sequence) {
    last = emit(*sink.value(), example_frame(sequence));
    if (last.ok()) ++written;
  }
  REQUIRE_FALSE(last.ok());
  CHECK(last.error().code == ErrorCode::NoSpace);
  CHECK(last.error().message.find(fmt::format("'{}/{:04}.exr'", folder, written)) != std::string::npos);
  CHECK(written > 0);
  std::uint64_t whole = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".exr") continue;
    CHECK(read_exr(posix_storage(), entry.path().string()).ok());
    ++whole;
  }
  CHECK(whole == written);
}

TEST_CASE("frames.csv lists number, time, exposure and verdict of every frame that left, gaps and all") {
  const std::string folder = scratch_folder("exr-ledger");
  auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr", {});
  REQUIRE(sink.ok());
  for (const std::uint64_t sequence : {41U, 44U}) {
    HdrFrame frame = example_frame(sequence);
    frame.facts.timestamp = Instant::from_seconds(static_cast<double>(sequence));
    frame.facts.verdict = Verdict::Proved;
    FrameRecord record;
    record.time_s = static_cast<double>(sequence) - 41;
    REQUIRE(sink.value()->emit({frame, ExposedFrame{}, record}).ok());
  }
  // not only at the end: a run may be killed
  const std::string text = read_whole(posix_storage(), folder + "/frames.csv").value();
  CHECK_THAT(text, Catch::StartsWith("number,time_s,timestamp_s,exposure_s,"));
  CHECK_THAT(text, Contains("\n41,0.000000000,41.000000000,0.004,") &&
                       Contains("\n44,3.000000000,44.000000000,0.004,") && Contains(",proved,0044.exr\n"));
  CHECK(std::count(text.begin(), text.end(), '\n') == 3);
}

TEST_CASE("of two runs that begin together with the same names of frames the later one replaces no frame") {
  const std::string folder = scratch_folder("exr-two-runs");
  const auto begun = [&] { return create_exr_sequence(posix_storage(), folder + "/%04d.exr", {}).value(); };
  const auto first = begun();
  auto second = begun();
  REQUIRE(emit(*first, example_frame(41)).ok());
  const std::string frame = read_whole(posix_storage(), folder + "/0041.exr").value();
  HdrFrame other = example_frame(41);
  other.radiance.fill(0.5f);
  const Result<void> late = emit(*second, other);
  REQUIRE_FALSE(late.ok());
  CHECK(late.error().code == ErrorCode::Exists);
  CHECK(read_whole(posix_storage(), folder + "/0041.exr").value() == frame);
  second.reset();
  CHECK(sample::unfinished_files_in(folder) == 0);
  REQUIRE(emit(*first, example_frame(42)).ok());
}

TEST_CASE("what a file states of its place in the run counts only where it can be") {
  const auto stated = [](const char* text) {
    ExrAttributes attributes;
    attributes.texts = {{"hdrcam.secondsSinceStart", text}, {"hdrcam.white", text}};
    return run_facts_of(attributes);
  };
  CHECK(stated("2.5").since_start_s == 2.5);
  CHECK(stated("2.5").white == 2.5);
  for (const char* text : {"-1", "1e300", "nan", "soon"}) {
    INFO(text);
    CHECK_FALSE(stated(text).since_start_s.has_value());
    CHECK_FALSE(stated(text).white.has_value());
  }
  CHECK_FALSE(stated("1e10").since_start_s.has_value());  // more than a clock of nanoseconds counts
}

TEST_CASE("a clock that was set back costs the time code, not the run") {
  const std::string folder = scratch_folder("exr-backwards");
  auto sink = create_exr_sequence(posix_storage(), folder + "/%04d.exr", {.framerate_hz = 25.0});
  HdrFrame frame = example_frame(1);
  frame.facts.timestamp = Instant::from_seconds(10);
  REQUIRE(emit(*sink.value(), frame).ok());
  frame = example_frame(2);
  frame.facts.timestamp = Instant::from_seconds(9);
  REQUIRE(emit(*sink.value(), frame).ok());
  CHECK_FALSE(read_exr(posix_storage(), folder + "/0002.exr").value().attributes.time_code);
}

TEST_CASE("a folder that cannot be made is an error before the first frame") {
  const auto sink = create_exr_sequence(posix_storage(), "/proc/no/such/%04d.exr", {});
  REQUIRE_FALSE(sink.ok());
  CHECK_THAT(sink.error().message, Contains("/proc/no/such"));
}
