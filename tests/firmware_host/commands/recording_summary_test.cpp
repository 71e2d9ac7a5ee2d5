// What `info` says of a recording, as a table and as JSON.
#include "firmware_host/commands/recording_summary.h"

#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "firmware_host/exit_code.h"
#include "hal/fault/faulty_storage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/ran_here.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::ran_here;

namespace {

const std::atomic<bool> kNeverStops{false};

}  // namespace

TEST_CASE("names in a recording cannot move the cursor of a terminal") {
  const std::string path = sample::scratch_folder("escape") + "/x.mkv";
  CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  camera.name = "\x1b[2Jgone\a";
  REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 3, 2)).ok());
  const std::string table = as_table(summarize(posix_storage(), path, kNeverStops).value(), path);
  CHECK(table.find('\x1b') == std::string::npos);
  CHECK(table.find("\\u001B[2Jgone\\u0007") != std::string::npos);
}

TEST_CASE(
    "info says that estimated exposures are relative, the white balance that the camera states, the codec, "
    "and "
    "that pictures were turned") {
  const std::string path = sample::scratch_folder("info_estimated") + "/x.mkv";
  CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  camera.white_balance = ChannelGains{2.125, 1, 1.5};
  camera.turned_upright = true;
  auto frames = sample::frames(camera, 8, 2);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameFacts& facts = frames[i].facts;
    facts.exposure_s = i % 2 == 0 ? 0.001 : 0.016;
    facts.analogue_gain = facts.digital_gain = 1;
    facts.exposure_source = ExposureSource::Estimated, facts.verdict = Verdict::Estimated;
  }
  REQUIRE(sample::record(posix_storage(), path, camera, frames, RecordingCodec::Ffv1).ok());
  const auto summary = summarize(posix_storage(), path, kNeverStops);
  REQUIRE(summary.ok());
  const std::string table = as_table(summary.value(), path);
  for (const char* words : {"estimated from the pictures, relative, 4.00 EV", "8 estimated",
                            "gains 2.125, 1, 1.5", "MB, ffv1", "upright, when it was imported"}) {
    INFO(table << words);
    CHECK(table.find(words) != std::string::npos);
  }
  CHECK(table.find("EV about") == std::string::npos);
  const auto json = nlohmann::json::parse(as_json(summary.value(), path));
  CHECK(json.at("verdicts").at("estimated") == 8);
  CHECK(json.at("exposure_sources").at("estimated") == 8);
  CHECK(json.at("white_balance") == nlohmann::json{2.125, 1.0, 1.5});
  CHECK(json.at("turned_upright") == true);
}

TEST_CASE("info calls exposures with a gain products, and those without one times") {
  const std::string path = sample::scratch_folder("info_gain") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  for (const double gain : {1., 8.}) {
    auto frames = sample::frames(camera, 8, 2);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      FrameFacts& facts = frames[i].facts;
      facts.sequence = i, facts.exposure_source = ExposureSource::Declared;
      facts.exposure_s = i % 2 == 0 ? 0.001 : 0.016;
      facts.analogue_gain = gain, facts.digital_gain = 1;
    }
    REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
    const auto summary = summarize(posix_storage(), path, kNeverStops);
    REQUIRE(summary.ok());
    const std::string table = as_table(summary.value(), path);
    const bool times = gain == 1;
    for (const char* words : {times ? "EV about 0.004 s\n" : "EV about 0.032 s x gain\n",
                              times ? "0.001 .. 0.016 s, 4.00 EV" : "0.008 .. 0.128 s x gain, 4.00 EV"}) {
      INFO(table << words);
      CHECK(table.find(words) != std::string::npos);
    }
  }
}

TEST_CASE("info shows the first black level that a frame states, though the first frame states none") {
  const std::string path = sample::scratch_folder("info_black") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::BayerRggb, 10, 32, 16);
  auto frames = sample::frames(camera, 3, 2);
  frames[0].facts.black_level.reset();
  frames[1].facts.black_level = BlackLevel::of_code(64, 10);
  frames[2].facts.black_level = BlackLevel::of_code(80, 10);
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto summary = summarize(posix_storage(), path, kNeverStops);
  REQUIRE(summary.ok());
  const std::string table = as_table(summary.value(), path);
  INFO(table);
  CHECK(table.find("15.95 codes of 255") != std::string::npos);
}

TEST_CASE("info counts what is there and what is missing") {
  const std::string path = sample::scratch_folder("info") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  auto frames = sample::frames(camera, 12, 2);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameFacts& facts = frames[i].facts;
    facts.sequence = i + (i >= 5 ? 2 : 0) + (i >= 9 ? 1 : 0);
    facts.exposure_s = facts.sequence % 2 == 0 ? 0.001 : 0.016;
    facts.analogue_gain = facts.digital_gain = 1;
    facts.flags = i == 5 ? kFrameAfterDrop | kFrameExposureUnproved : 0;
    facts.exposure_source = ExposureSource::Declared;
  }
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto summary = summarize(posix_storage(), path, kNeverStops);
  REQUIRE(summary.ok());
  const RecordingSummary& info = summary.value();
  CHECK(info.frames == 12);
  CHECK((info.dropped == 3 && info.gaps == 2));
  CHECK(info.unproved == 1);
  CHECK(info.with_pose == 6);
  CHECK(info.cycle.period == 2);
  CHECK(info.shortest_exposure_s == 0.001);
  CHECK(info.longest_exposure_s == 0.016);
  CHECK(info.bytes == std::filesystem::file_size(path));
  CHECK(!info.end);
  const auto json = nlohmann::json::parse(as_json(info, path));
  CHECK(json.at("complete") == true);
  CHECK(json.at("exposure_range_ev").get<double>() == Approx(4));
  CHECK(json.at("slots_ev").get<std::vector<double>>() == std::vector<double>{-2, 2});
  CHECK_FALSE(json.contains("white_balance"));  // none is stated
  const std::string table = as_table(info, path);
  for (const char* words : {"37x23, 8 bits, rgb", "2 slots: -2.00 / +2.00 EV about 0.004 s", "4.00 EV",
                            "12 in", "3 in 2 gaps", "complete    yes"}) {
    INFO(table << words);
    CHECK(table.find(words) != std::string::npos);
  }
  CHECK(ran_here({"info", "--json", path}).exit_code == kExitOk);

  FaultyStorage disk(posix_storage(), {.cut_at_bytes = info.bytes / 2});
  const auto cut = summarize(disk, path, kNeverStops);
  REQUIRE(cut.ok());
  REQUIRE(cut.value().end);
  CHECK(cut.value().end->code == ErrorCode::Truncated);
  CHECK(cut.value().frames < 12);
  CHECK(ran_here({"info", path + ".none"}).exit_code == exit_code_of(ErrorCode::NotFound));
}

TEST_CASE("info that is told to stop ends before it has read all, and says so") {
  const std::string path = sample::scratch_folder("info_stopped") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 3, 2)).ok());
  const test::RanHere stopped = ran_here({"info", path}, posix_storage(), true);
  CHECK(stopped.exit_code == kExitInterrupted);
  CHECK(stopped.err.find("stopped after 0 frames of '" + path + "'") != std::string::npos);
}
