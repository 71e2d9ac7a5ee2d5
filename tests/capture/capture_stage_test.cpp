// The capture stage and its camera: what is lost, refused, learned and said. Whether its labels are right:
// capture_labels_test.cpp.
#include "capture/capture_stage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tests/allocation_checks.h"
#include "tests/capture/misbehaving_camera.h"

namespace hdrcam {
namespace {

using test::MisbehavingCamera;
using test::SensorKind;
using test::SensorSettings;
using test::StrobeModel;
using namespace std::chrono_literals;

constexpr Exposure kOne[] = {{4ms, 1}};
constexpr Exposure kThree[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

TEST_CASE("a run of one exposure that nobody states says why every frame is unknown", "[capture]") {
  const auto account_of = [](const SensorSettings& settings, std::span<const Exposure> cycle) {
    MisbehavingCamera sensor(settings, {});
    auto stage = CaptureStage::open(sensor, nullptr, cycle, Mains::Off, {});
    REQUIRE((*stage)->start().ok());
    CapturedFrame frame;
    for (int i = 0; i < 20; ++i) REQUIRE((*stage)->next(frame).ok());
    const auto& warnings = (*stage)->warnings();
    const bool promises = std::ranges::any_of(warnings, [](const std::string& warning) {
      return warning.find("labelled by their pictures alone") != std::string::npos;
    });
    CHECK(promises == (!settings.per_request && cycle.size() > 1));
    return (*stage)->exposures_account();
  };
  const SensorSettings silent{
      .kind = SensorKind::Gamma8, .per_request = false, .latency = 2, .gain_latency = 2};
  const std::string account = account_of(silent, kOne);
  CHECK(account.starts_with("the exposure of every frame is unknown: "));
  CHECK(account.find("run 'hdrcam calibrate delay' once") != std::string::npos);
  CHECK(account_of(silent, kThree).empty());
  CHECK(account_of({.kind = SensorKind::Gamma8}, kOne).empty());  // its requests tell
}

TEST_CASE("lost frames are counted, and the frame after them says so", "[capture]") {
  MisbehavingCamera sensor({}, {.drop = 0.1, .drop_run = 3, .damage = 0.05});
  auto stage = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, {});
  REQUIRE(stage.ok());
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  std::uint64_t gaps = 0;
  for (int i = 0; i < 300; ++i) {
    REQUIRE((*stage)->next(frame).ok());
    gaps += static_cast<std::uint64_t>(frame.lost_before);
    CHECK((frame.lost_before > 0) == ((frame.raw.facts.flags & kFrameAfterDrop) != 0));
  }
  const CaptureCounters& counters = (*stage)->counters();
  CHECK(counters.captured + counters.lost_by_camera == sensor.frames());
  CHECK(gaps == counters.lost_by_camera + counters.damaged);
  REQUIRE((*stage)->stop().ok());
  const auto after = (*stage)->next(frame);
  REQUIRE_FALSE(after.ok());
  CHECK(after.error().code == ErrorCode::Interrupted);
}

class SilentCamera : public MisbehavingCamera {
 public:
  using MisbehavingCamera::MisbehavingCamera;
  Result<CapturedBuffer> wait(Duration timeout) override {
    waits.push_back(timeout);
    return Error{ErrorCode::Timeout, "no frame came"};
  }

  std::vector<Duration> waits;
};

TEST_CASE("while no frame comes, whether the run is to end is asked every two seconds", "[capture]") {
  SilentCamera sensor({}, {});
  CaptureOptions options;
  options.patience = 7s;
  auto stage = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, options);
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  int asked = 0;
  const auto ended = (*stage)->next(frame, [&asked] { return ++asked == 2; });
  REQUIRE_FALSE(ended.ok());
  CHECK(ended.error().code == ErrorCode::Interrupted);
  CHECK(sensor.waits == std::vector<Duration>{2s, 2s});

  sensor.waits.clear();
  const auto silent = (*stage)->next(frame, [] { return false; });
  REQUIRE_FALSE(silent.ok());
  CHECK(silent.error().code == ErrorCode::Timeout);
  CHECK(silent.error().message == "no frame came, nor in the 6 s before");
  CHECK(sensor.waits == std::vector<Duration>{2s, 2s, 2s, 1s});

  sensor.waits.clear();
  CHECK((*stage)->next(frame).error().message == "no frame came");
  CHECK(sensor.waits == std::vector<Duration>{7s});
}

TEST_CASE("the response of the fit makes the proof exact", "[capture]") {
  MisbehavingCamera sensor({.kind = SensorKind::Gamma8, .pan_px = 1}, {});
  auto stage = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, {});
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  const auto widest_proof = [&] {
    double widest = 0;
    for (int i = 0; i < 60; ++i) {
      REQUIRE((*stage)->next(frame).ok());
      if (frame.proof.verdict == Verdict::Proved) widest = std::max(widest, frame.proof.within_ev);
    }
    return widest;
  };
  CHECK(widest_proof() > 1);
  PhotometricResponse::Curve inverse{};
  for (std::size_t z = 0; z < inverse.size(); ++z) inverse[z] = std::pow(static_cast<float>(z) / 255, 2.2f);
  (*stage)->learn_response(inverse, BlackLevel());
  CHECK(widest_proof() < 0.8);
}

// Counts what the model allocates, so that the rest is what the stage does.
class CountingCamera : public Camera {
  template <class Call>
  auto counted(Call&& call) {
    const std::uint64_t before = allocations_so_far();
    auto result = call();
    inside_ += allocations_so_far() - before;
    return result;
  }

 public:
  explicit CountingCamera(Camera& camera) : camera_(camera) {}
  const CameraCapabilities& capabilities() const override { return camera_.capabilities(); }
  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    return camera_.configure(wanted, buffers);
  }
  Result<void> start() override { return camera_.start(); }
  Result<void> queue(const ExposureRequest& request) override {
    return counted([&] { return camera_.queue(request); });
  }
  Result<CapturedBuffer> wait(Duration timeout) override {
    return counted([&] { return camera_.wait(timeout); });
  }
  Result<void> stop() override { return camera_.stop(); }
  std::uint64_t inside() const { return inside_; }

 private:
  Camera& camera_;
  std::uint64_t inside_ = 0;
};

TEST_CASE("capture does not allocate once it runs", "[capture]") {
  MisbehavingCamera sensor({.reports = true}, {.drop = 0.05, .exposure_late = 0.05});
  CountingCamera camera(sensor);
  StrobeModel strobe(sensor);
  auto stage = CaptureStage::open(camera, &strobe, kThree, Mains::Off, {});
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  bool ok = (*stage)->next(frame).ok();
  const std::uint64_t before = allocations_so_far(), before_inside = camera.inside();
  for (int i = 0; i < 400; ++i) ok &= (*stage)->next(frame).ok();
  const std::uint64_t by_stage = allocations_so_far() - before - (camera.inside() - before_inside);
  CHECK(ok);
  CHECK_ALLOCATIONS(by_stage == 0);
}

// Something happens to it while a request is being queued, which it then refuses: the one after a request for
// each buffer and `more` others.
class RefusingCamera : public MisbehavingCamera {
 public:
  static constexpr int kBuffers = 8;

  RefusingCamera(int more, const Error& refusal)
      : MisbehavingCamera({}, {}), left_(kBuffers + more), refusal_(refusal) {}
  void set_happens(std::function<void()> happens) { happens_ = std::move(happens); }
  Result<void> queue(const ExposureRequest& request) override {
    if (left_-- > 0) return MisbehavingCamera::queue(request);
    if (happens_) happens_();
    return refusal_;
  }

 private:
  int left_;
  Error refusal_;
  std::function<void()> happens_;
};

std::unique_ptr<CaptureStage> opened_on(RefusingCamera& camera) {
  auto opened =
      CaptureStage::open(camera, nullptr, kThree, Mains::Off, {.buffers = RefusingCamera::kBuffers});
  REQUIRE(opened.ok());
  return std::move(*opened);
}

TEST_CASE("the frame that came before the camera refused a request is delivered, then the refusal is told",
          "[capture]") {
  RefusingCamera sensor(5, {ErrorCode::Unplugged, "the model went away"});
  const auto stage = opened_on(sensor);
  REQUIRE(stage->start().ok());
  CapturedFrame frame;
  for (int i = 0; i < 6; ++i) REQUIRE(stage->next(frame).ok());
  const Result<void> refused = stage->next(frame);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Unplugged);
  CHECK(stage->counters().emitted == 6);
  CHECK(stage->counters().captured == 6);
}

TEST_CASE("a stop by another thread while a request is queued is an interruption, not a fault", "[capture]") {
  RefusingCamera sensor(1, {ErrorCode::Invalid, "the model is not started"});
  const auto stage = opened_on(sensor);
  sensor.set_happens([&] { (void)stage->stop(); });
  REQUIRE(stage->start().ok());
  CapturedFrame frame;
  for (int i = 0; i < 2; ++i) REQUIRE(stage->next(frame).ok());
  const Result<void> stopped = stage->next(frame);
  REQUIRE_FALSE(stopped.ok());
  CHECK(stopped.error().code == ErrorCode::Interrupted);
}

// Has its own number of buffers, whatever is asked for.
class OwnBuffersCamera : public MisbehavingCamera {
 public:
  explicit OwnBuffersCamera(int buffers)
      : MisbehavingCamera({}, {}), can_(MisbehavingCamera::capabilities()) {
    can_.buffers = buffers;
  }
  const CameraCapabilities& capabilities() const override { return can_; }
  Result<StreamMode> configure(const StreamMode& wanted, int) override {
    return MisbehavingCamera::configure(wanted, *can_.buffers);
  }
  Result<void> queue(const ExposureRequest& request) override {
    const Result<void> taken = MisbehavingCamera::queue(request);
    requests_ += taken.ok();
    return taken;
  }
  int requests() const { return requests_; }

 private:
  CameraCapabilities can_;
  int requests_ = 0;
};

TEST_CASE("all buffers that a camera has are used, and that they are few is told", "[capture]") {
  CaptureOptions options;
  options.buffers = 8;
  for (const int buffers : {3, 8, 10}) {
    OwnBuffersCamera sensor(buffers);
    auto opened = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, options);
    REQUIRE(opened.ok());
    CaptureStage& stage = **opened;
    REQUIRE(stage.start().ok());
    CHECK(sensor.requests() == buffers);
    const auto& all = stage.warnings();
    const bool told = std::any_of(all.begin(), all.end(), [](const std::string& warning) {
      return warning.find("has 3 buffers, not the 8 of --buffers") != std::string::npos;
    });
    CHECK(told == (buffers == 3));
    CapturedFrame frame;
    for (int i = 0; i < 20; ++i) REQUIRE(stage.next(frame).ok());
  }
}

TEST_CASE("what a camera cannot do is said before it starts", "[capture]") {
  MisbehavingCamera sensor({}, {});
  constexpr Exposure kTooLong[] = {{1ms, 1}, {40ms, 1}};
  const auto late = CaptureStage::open(sensor, nullptr, kTooLong, Mains::Off, {});
  REQUIRE_FALSE(late.ok());
  CHECK(late.error().code == ErrorCode::BadExposure);
  CHECK(late.error().message.find("40 ms") != std::string::npos);

  MisbehavingCamera unknown({.kind = SensorKind::Gamma8, .per_request = false}, {});
  auto stage = CaptureStage::open(unknown, nullptr, kThree, Mains::Hz50, {});
  REQUIRE(stage.ok());
  REQUIRE((*stage)->warnings().size() == 3);  // two short exposures, and an unknown delay
  CHECK((*stage)->warnings()[2].find("calibrate delay") != std::string::npos);
}

}  // namespace
}  // namespace hdrcam
