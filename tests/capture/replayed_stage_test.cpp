// Recordings and the capture stage: what one states goes through the stage as it was stated, live on a paced
// replay; and what the stage delivers of a faulty camera makes a recording that is whole.
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/capture_stage.h"
#include "hal/fault/faulty_camera.h"
#include "hal/recording/recording.h"
#include "hal/replay/replayed_camera.h"
#include "hal/sim/simulated_camera.h"
#include "hal/sim/virtual_clock.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"

using namespace hdrcam;
using Catch::Contains;

namespace {

constexpr int kFrames = 24, kBits = 12;
constexpr BlackLevel kBlack(16);  // of 255

struct Stated {
  double exposure_s = 0;
  BlackLevel black = kBlack;
  double digital_gain = 1;
};
constexpr Stated kAlternating[] = {{0.002}, {0.008}};

PoseMatrix pose_of(int frame) { return {1, 0, 0, 0.1 * frame, 0, 1, 0, 0, 0, 0, 1, 0}; }
bool is_late(int frame) { return frame % 5 == 2; }

// A smooth scene that does not move, raw, exposed in turn like this.
std::string write_recording(const std::string& name, ExposureSource source,
                            std::span<const Stated> stated = kAlternating) {
  CameraFacts camera = sample::camera(PixelLayout::BayerRggb, kBits, 64, 48);
  camera.name = "/dev/video0", camera.linear = true;
  const std::string path = sample::scratch_folder(name) + "/r.mkv";
  auto writer = value_of(create_recording(posix_storage(), path, camera));
  for (int i = 0; i < kFrames; ++i) {
    RawFrame frame{{}, Image<std::uint16_t>(1, camera.height, camera.width)};
    frame.facts.sequence = static_cast<std::uint64_t>(i);
    const Stated& of = stated[static_cast<std::size_t>(i) % stated.size()];
    frame.facts.exposure_s = of.exposure_s, frame.facts.digital_gain = of.digital_gain;
    frame.facts.timestamp = Instant::from_seconds(1 + i / camera.framerate_hz);
    frame.facts.exposure_source = source;
    frame.facts.black_level = of.black;
    frame.facts.T_world_camera = pose_of(i);
    if (is_late(i)) frame.facts.flags = kFrameTriggerLate;
    const double black = of.black.code(kBits);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const double radiance = 200 + 150 * std::sin(x * 0.3) * std::cos(y * 0.2);  // codes per ms
        frame.codes.at(0, y, x) = static_cast<std::uint16_t>(
            std::min(4095.0, black + radiance * frame.facts.exposure() * 1e3 + 0.5));
      }
    require_done(writer->append(frame));
  }
  require_done(writer->finish());
  return path;
}

std::vector<CapturedFrame> captured_from(const std::string& path, CaptureOptions options = {}) {
  auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
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

TEST_CASE("frames of a replay keep the black level that each states, and are proved by it") {
  const Stated stated[] = {{0.008, BlackLevel(16)}, {0.002, BlackLevel(24)}};
  const std::string path = write_recording("stage_blacks", ExposureSource::Reported, stated);
  const auto frames = captured_from(path);
  int proved = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    REQUIRE(frames[i].raw.facts.black_level);
    CHECK(frames[i].raw.facts.black_level->code(kBits) == stated[i % 2].black.code(kBits));
    proved += frames[i].proof.verdict == Verdict::Proved ? 1 : 0;
  }
  CHECK(proved >= kFrames - 4);

  CaptureOptions by_user;
  by_user.black_level = BlackLevel(5);
  for (const CapturedFrame& frame : captured_from(path, by_user))
    CHECK(frame.raw.facts.black_level == by_user.black_level);
}

TEST_CASE("frames of a replay keep their poses and the flag of a late trigger pulse") {
  const auto frames = captured_from(write_recording("stage_poses", ExposureSource::Reported));
  for (int i = 0; i < kFrames; ++i) {
    const FrameFacts& facts = frames[static_cast<std::size_t>(i)].raw.facts;
    CAPTURE(i);
    CHECK(facts.T_world_camera == pose_of(i));
    CHECK(((facts.flags & kFrameTriggerLate) != 0) == is_late(i));
  }
}

TEST_CASE("frames of a replay that differ in digital gain alone have the slots of their exposures") {
  const Stated stated[] = {{.exposure_s = 0.002}, {.exposure_s = 0.002, .digital_gain = 4}};
  const auto frames = captured_from(write_recording("stage_digital", ExposureSource::Reported, stated));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    REQUIRE(frames[i].proof.trusted());
    CHECK(frames[i].raw.facts.digital_gain == stated[i % 2].digital_gain);
    CHECK(frames[i].raw.facts.slot == static_cast<int>(i % 2));
  }
}

TEST_CASE("a recording that plays the camera keeps its lens, its response and what its codes are") {
  for (const bool linear : {false, true}) {
    CameraFacts recorded = sample::camera(PixelLayout::Rgb, 8, 32, 16);
    recorded.linear = linear;
    recorded.intrinsics = Intrinsics{40, 41, 16, 8};
    recorded.white_balance = ChannelGains{1.5, 1, 2};
    if (!linear) recorded.response.assign(3, std::vector<double>(256));
    for (std::vector<double>& curve : recorded.response)
      for (std::size_t z = 0; z < curve.size(); ++z) curve[z] = std::pow(static_cast<double>(z) / 255, 2);
    auto frames = sample::frames(recorded, 6, 1);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].facts.exposure_s = i % 2 == 0 ? 0.001 : 0.004;
      frames[i].facts.analogue_gain = frames[i].facts.digital_gain = 1;
      frames[i].facts.slot = static_cast<int>(i % 2);
    }
    const std::string path = sample::scratch_folder("stage_camera") + "/r.mkv";
    require_done(sample::record(posix_storage(), path, recorded, frames));
    auto camera =
        value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
    CaptureOptions options;
    options.mode = camera->capabilities().modes.front();
    const CameraFacts facts =
        value_of(CaptureStage::open(*camera, nullptr, {}, Mains::Off, options))->facts();
    CHECK(facts.name == "replay:" + path);
    CHECK(facts.linear == linear);
    REQUIRE(facts.intrinsics);
    CHECK(facts.intrinsics->fy_px == 41);
    CHECK(facts.white_balance == recorded.white_balance);
    CHECK(facts.response == recorded.response);
  }
}

TEST_CASE("settings of the camera's clock and delays move and doubt nothing of a recording that plays it") {
  CaptureOptions options;
  options.timestamp_mark = TimestampMark::ExposureEnd, options.delays = ControlDelays{1, 1};
  const auto frames = captured_from(write_recording("stage_settings", ExposureSource::Reported), options);
  const double framerate_hz = sample::camera(PixelLayout::BayerRggb, kBits, 64, 48).framerate_hz;
  for (int i = 0; i < kFrames; ++i) {
    const CapturedFrame& frame = frames[static_cast<std::size_t>(i)];
    CHECK(frame.raw.facts.timestamp.seconds() == Approx(1 + i / framerate_hz).margin(1e-8));
    CHECK(frame.proof.trusted());
  }
}

TEST_CASE("exposures that came from the pictures stay estimated through the capture stage") {
  int trusted = 0;
  for (const CapturedFrame& frame :
       captured_from(write_recording("stage_estimated", ExposureSource::Estimated))) {
    CHECK(frame.raw.facts.exposure_source == ExposureSource::Estimated);
    CHECK_FALSE(frame.raw.facts.has_exposure_time());
    CHECK(frame.raw.facts.verdict == frame.proof.verdict);
    if (frame.proof.trusted()) CHECK(frame.proof.verdict == Verdict::Estimated);
    trusted += frame.proof.trusted();
  }
  CHECK(trusted >= kFrames - 4);
}

TEST_CASE("estimated exposures, which are no times, move no frame of a replay, and none seems to be lost") {
  const Stated stated[] = {{0.008}, {0.020}, {0.048}};
  const auto frames = captured_from(write_recording("stage_no_times", ExposureSource::Estimated, stated));
  const double framerate_hz = sample::camera(PixelLayout::BayerRggb, kBits, 64, 48).framerate_hz;
  for (int i = 0; i < kFrames; ++i) {
    const CapturedFrame& frame = frames[static_cast<std::size_t>(i)];
    CAPTURE(i);
    CHECK(frame.raw.facts.timestamp == Instant::from_seconds(1 + i / framerate_hz));
    CHECK(frame.lost_before == 0);
    CHECK((frame.raw.facts.flags & kFrameAfterDrop) == 0);
  }
}

TEST_CASE(
    "a recording that follows no cycle, or too long a one, is no camera, and the error names both ways out") {
  const CameraFacts facts = sample::camera(PixelLayout::Rgb, 8, 32, 16);
  for (const int count : {5, 15}) {  // once through, and three times through five exposures
    auto frames = sample::frames(facts, count, 1);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].facts.exposure_s = std::ldexp(0.001, static_cast<int>(i % 5));
      frames[i].facts.analogue_gain = frames[i].facts.digital_gain = 1;
      frames[i].facts.slot = -1;
    }
    const std::string path = sample::scratch_folder("stage_no_cycle") + "/r.mkv";
    require_done(sample::record(posix_storage(), path, facts, frames));
    auto camera =
        value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock()));
    CHECK(camera->capabilities().cycle.size() == (count == 5 ? 0 : 5));
    CaptureOptions options;
    options.mode = camera->capabilities().modes.front();
    const auto refused = CaptureStage::open(*camera, nullptr, {}, Mains::Off, options);
    require_error(refused, ErrorCode::Unsupported);
    CHECK_THAT(refused.error().message,
               Contains("no cycle of 1 to 4 exposures") &&
                   Contains("choose another camera, or read a recording without --pace realtime"));
  }
}

namespace {

// A camera whose driver's counter begins again at 0 with this buffer.
class RestartingCounter : public Camera {
 public:
  RestartingCounter(std::unique_ptr<Camera> inner, std::uint64_t at) : inner_(std::move(inner)), at_(at) {}
  const CameraCapabilities& capabilities() const override { return inner_->capabilities(); }
  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    return inner_->configure(wanted, buffers);
  }
  Result<void> start() override { return inner_->start(); }
  Result<void> queue(const ExposureRequest& request) override { return inner_->queue(request); }
  Result<void> stop() override { return inner_->stop(); }
  Result<CapturedBuffer> wait(Duration timeout) override {
    CapturedBuffer buffer = TRY(inner_->wait(timeout));
    if (delivered_++ == at_) offset_ = buffer.sequence;
    buffer.sequence -= offset_;
    return buffer;
  }

 private:
  std::unique_ptr<Camera> inner_;
  const std::uint64_t at_;
  std::uint64_t delivered_ = 0, offset_ = 0;
};

constexpr int kRecorded = 40;
const CaptureOptions kSmall{.mode = {PixelFormat::Rgb24, 32, 24, Duration(33'333'333)}};
constexpr Exposure kTwo[] = {{std::chrono::milliseconds(1), 1}, {std::chrono::milliseconds(4), 1}};

// What a reader finds of that many frames of a camera, recorded as the stage delivers them.
sample::Replayed recorded_from(const std::string& name, Camera& camera) {
  auto stage = value_of(CaptureStage::open(camera, nullptr, kTwo, Mains::Off, kSmall));
  const std::string path = sample::scratch_folder(name) + "/r.mkv";
  auto writer = value_of(create_recording(posix_storage(), path, stage->facts()));
  require_done(stage->start());
  CapturedFrame frame;
  for (int i = 0; i < kRecorded; ++i) {
    require_done(stage->next(frame));
    require_done(writer->append(frame.raw));
  }
  require_done(writer->finish());
  return sample::replay(posix_storage(), path);
}

std::unique_ptr<Camera> simulated(VirtualClock& clock) {
  return std::make_unique<SimulatedCamera>(value_of(simulation_of("still?size=32x24")), SimTime(clock), 1);
}

}  // namespace

TEST_CASE("a recording is whole though the driver repeats a number and a time goes back") {
  VirtualClock clock, clock_of_sound;
  FaultyCamera faulty(simulated(clock),
                      {{5, CameraFaultKind::SequenceRepeat}, {12, CameraFaultKind::StampBack}});
  const auto replayed = recorded_from("stage_faults", faulty);
  const auto sound = recorded_from("stage_sound", *simulated(clock_of_sound));
  REQUIRE_FALSE(replayed.error);
  REQUIRE_FALSE(sound.error);
  REQUIRE(replayed.frames.size() == kRecorded);
  REQUIRE(sound.frames.size() == kRecorded);
  for (std::size_t i = 0; i < kRecorded; ++i) {
    const FrameFacts &facts = replayed.frames[i].facts, &truth = sound.frames[i].facts;
    CAPTURE(i);
    CHECK(facts.sequence == truth.sequence);
    CHECK(facts.timestamp.seconds() == Approx(truth.timestamp.seconds()).margin(i == 12 ? 0.01 : 1e-9));
  }
}

// A camera whose frames 2 to 59 are faulty, but for the tenth.
struct FailingCamera {
  template <class KindOf>
  explicit FailingCamera(KindOf&& kind_of) {
    std::vector<CameraFault> faults;
    for (std::uint64_t i = 2; i < 60; ++i)
      if (i != 10) faults.push_back({i, kind_of(i)});
    camera = std::make_unique<FaultyCamera>(simulated(clock), faults);
    stage = value_of(CaptureStage::open(*camera, nullptr, kTwo, Mains::Off, kSmall));
    require_done(stage->start());
  }
  // Of the frame after the three that are whole.
  std::string end() {
    CapturedFrame frame;
    for (int i = 0; i < 3; ++i) require_done(stage->next(frame));
    CHECK(frame.lost_before == 8);
    const auto ended = stage->next(frame);
    require_error(ended, ErrorCode::Corrupt);
    CHECK(ended.error().message.starts_with("30 frames of '"));
    return ended.error().message;
  }

  VirtualClock clock;
  std::unique_ptr<FaultyCamera> camera;
  std::unique_ptr<CaptureStage> stage;
};

TEST_CASE("frames that do not decode are counted, and thirty in a row end the run with the first reason") {
  FailingCamera failing([](std::uint64_t) { return CameraFaultKind::Short; });
  CHECK_THAT(failing.end(), Contains("frame 11 has "));
  CHECK(failing.stage->counters().undecodable == 38);
}

TEST_CASE("thirty damaged frames in a row end the run, and the error says what to check") {
  FailingCamera failing([](std::uint64_t) { return CameraFaultKind::Damaged; });
  CHECK_THAT(failing.end(), Contains("incomplete pixels; check the camera's cable"));
  CHECK(failing.stage->counters().damaged == 38);
}

TEST_CASE("damaged frames and frames that do not decode are one row, which ends the run") {
  FailingCamera failing(
      [](std::uint64_t i) { return i % 2 == 0 ? CameraFaultKind::Damaged : CameraFaultKind::Short; });
  CHECK_THAT(failing.end(), Contains("frame 11 has "));
  CHECK(failing.stage->counters().damaged == 19);
  CHECK(failing.stage->counters().undecodable == 19);
}

TEST_CASE("a pixel format that cannot be unpacked ends the run at its first frame") {
  VirtualClock clock;
  auto inner = simulated(clock);
  class OddCamera : public FaultyCamera {
   public:
    using FaultyCamera::FaultyCamera;
    Result<CapturedBuffer> wait(Duration timeout) override {
      CapturedBuffer buffer = TRY(FaultyCamera::wait(timeout));
      buffer.mode.format = PixelFormat::Mjpeg;
      return buffer;
    }
  } camera(std::move(inner), {});
  auto stage = value_of(CaptureStage::open(camera, nullptr, kTwo, Mains::Off, kSmall));
  require_done(stage->start());
  CapturedFrame frame;
  const auto ended = stage->next(frame);
  require_error(ended, ErrorCode::Unsupported);
  CHECK(ended.error().message.find("MJPEG frames need a JPEG decoder") == 0);
}

TEST_CASE("frames after a counter that begins again go on in number, and none is lost") {
  VirtualClock clock;
  RestartingCounter camera(simulated(clock), 20);
  const auto replayed = recorded_from("stage_restart", camera);
  REQUIRE_FALSE(replayed.error);
  REQUIRE(replayed.frames.size() == kRecorded);
  for (std::size_t i = 0; i < kRecorded; ++i)
    CHECK(replayed.frames[i].facts.sequence == replayed.frames[0].facts.sequence + i);
}
