// What a recording states goes through the stage as it was stated: live on a paced replay.
#include <cmath>

#include "capture/capture_stage.h"
#include "hal/recording/recording.h"
#include "hal/replay/replayed_camera.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"

using namespace hdrcam;

namespace {

constexpr int kFrames = 24, kBits = 12;
const BlackLevel kBlack(16);  // of 255

// A smooth scene that does not move, raw, exposed in turn for 2 and 8 ms.
std::string write_recording(const std::string& name, ExposureSource source) {
  CameraFacts camera = sample::camera(PixelLayout::BayerRggb, kBits, 64, 48);
  camera.name = "/dev/video0", camera.linear = true;
  const std::string path = sample::scratch_folder(name) + "/r.mkv";
  auto writer = value_of(create_recording(posix_storage(), path, camera));
  for (int i = 0; i < kFrames; ++i) {
    RawFrame frame{{}, Image<std::uint16_t>(1, camera.height, camera.width)};
    frame.facts.sequence = static_cast<std::uint64_t>(i);
    frame.facts.exposure_s = i % 2 == 0 ? 0.002 : 0.008;
    frame.facts.timestamp = Instant::from_seconds(1 + i / camera.framerate_hz);
    frame.facts.exposure_source = source;
    frame.facts.black_level = kBlack;
    const double black = kBlack.code(kBits);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const double radiance = 200 + 150 * std::sin(x * 0.3) * std::cos(y * 0.2);  // codes per ms
        frame.codes.at(0, y, x) = static_cast<std::uint16_t>(
            std::min(4095.0, black + radiance * frame.facts.exposure_s * 1e3 + 0.5));
      }
    require_done(writer->append(frame));
  }
  require_done(writer->finish());
  return path;
}

std::vector<CapturedFrame> captured_from(const std::string& path) {
  auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
  CaptureOptions options;
  options.mode = camera->capabilities().modes.front();
  auto stage = value_of(CaptureStage::open(*camera, nullptr, {}, Mains::Off, options));
  require_done(stage->start());
  std::vector<CapturedFrame> frames(kFrames);
  for (CapturedFrame& frame : frames) require_done(stage->next(frame));
  require_done(stage->stop());
  return frames;
}

}  // namespace

TEST_CASE(
    "a replay through the capture stage proves exposures that were reported, at the black level stated") {
  int proved = 0;
  for (const CapturedFrame& frame :
       captured_from(write_recording("stage_reported", ExposureSource::Reported))) {
    CHECK(frame.raw.facts.exposure_source == ExposureSource::Reported);
    REQUIRE(frame.raw.facts.black_level);
    CHECK(frame.raw.facts.black_level->code(kBits) == kBlack.code(kBits));
    proved += frame.proof.verdict == Verdict::Proved ? 1 : 0;
  }
  CHECK(proved >= kFrames - 4);
}

TEST_CASE("exposures that came from the pictures stay estimated through the capture stage") {
  for (const CapturedFrame& frame :
       captured_from(write_recording("stage_estimated", ExposureSource::Estimated))) {
    CHECK(frame.raw.facts.exposure_source == ExposureSource::Estimated);
    CHECK_FALSE(frame.raw.facts.has_exposure_time());
    CHECK(frame.raw.facts.verdict == frame.proof.verdict);
    if (frame.proof.trusted()) CHECK(frame.proof.verdict == Verdict::Estimated);
  }
}
