// A run that lasts: what grows with the number of frames would end a camera's life.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "firmware_host/live/camera_source.h"
#include "firmware_host/run/run.h"
#include "tests/allocation_checks.h"
#include "tests/support/becomes_true.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

std::size_t threads_of_this_process() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& task : std::filesystem::directory_iterator("/proc/self/task")) ++count;
  return count;
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

struct Growth {
  bool measured = false;
  std::uint64_t allocations = 0;
  std::ptrdiff_t bytes = 0;
  int unbalanced = 0;    // moments at which frames were in no ledger
  int wrong_labels = 0;  // frames that are not as bright as their exposure makes the scene
};

// A camera that films a scene without change and noise. Notes what the process has taken once `warm` frames
// were captured and the fit has seen every kind of frame, and at the end; judges ledger and label at each
// frame. In between the fit is late once by `hold_up`, in which frames wait for it.
class WatchedCamera : public FrameSource {
 public:
  WatchedCamera(CameraSource& camera, std::uint64_t warm, Duration hold_up)
      : camera_(camera), warm_(warm), hold_up_(hold_up) {}

  const CameraFacts& camera() const override { return camera_.camera(); }
  RunPace pace() const override { return camera_.pace(); }
  Result<void> start() override { return camera_.start(); }
  Result<const RawFrame*> next() override {
    Result<const RawFrame*> frame = camera_.next();
    const LiveCounters counters = camera_.session().counters();
    growth_.unbalanced += counters.captured() != counters.emitted + counters.dropped() + counters.in_fit;
    if (frame && frame.value() != nullptr) growth_.wrong_labels += !labelled_right(*frame.value());
    if (!growth_.measured && counters.captured() >= warm_ && counters.emitted >= kWarmFit) {
      growth_.measured = true;
      warm_allocations_ = own_allocations_so_far(), warm_bytes_ = resident_bytes();
      std::this_thread::sleep_for(hold_up_);
    }
    if (growth_.measured && frame && frame.value() == nullptr) {
      growth_.allocations = own_allocations_so_far() - warm_allocations_;
      growth_.bytes =
          static_cast<std::ptrdiff_t>(resident_bytes()) - static_cast<std::ptrdiff_t>(warm_bytes_);
    }
    return frame;
  }
  void emitted(FrameRecord& record) override { camera_.emitted(record); }
  void left_out() override { camera_.left_out(); }
  void learn_response(const Response::Curve& inverse, const BlackLevel& black) override {
    camera_.learn_response(inverse, black);
  }
  Result<void> finish(RunRecord& record) override { return camera_.finish(record); }

  const Growth& growth() const { return growth_; }

 private:
  // Frames of one exposure are equal, and a longer exposure is brighter.
  bool labelled_right(const RawFrame& frame) {
    double sum = 0;
    for (const std::uint16_t code : frame.codes.samples()) sum += code;
    const auto [known, is_new] = brightness_.try_emplace(std::llround(frame.facts.exposure_s * 1e6), sum);
    const bool rises = known == brightness_.begin() || std::prev(known)->second < sum;
    return (is_new || known->second == sum) && rises;
  }

  static constexpr std::uint64_t kWarmFit = 20;  // HDR frames: the window is full, and has moved on
  CameraSource& camera_;
  const std::uint64_t warm_;
  const Duration hold_up_;
  std::uint64_t warm_allocations_ = 0;
  std::size_t warm_bytes_ = 0;
  std::map<std::int64_t, double> brightness_;  // sum of codes by exposure, us
  Growth growth_;
};

// What the process took from the moment when `warm` frames were captured until the end.
Growth growth_over(std::uint64_t frames, std::uint64_t warm, Settings settings) {
  settings.camera.id = "sim:still?size=48x32&fps=250&without=noise";
  settings.camera.format = "RGB24";
  settings.schedule.shutter = "1ms,2ms";
  settings.fit.preset = Preset::Fast;
  settings.fit.threads = 2;
  settings.record.memory_mib = 1;  // all frames that may wait, used or not, are less than the growth allowed
  // some 37 frames wait; where there is a governor it would answer with another rung
  const Duration hold_up = settings.fit.deadline == kOff ? milliseconds(150) : milliseconds(0);
  const std::atomic<bool> never{false};
  const auto camera = value_of(CameraSource::open(settings, {.frames = frames}, posix_storage(), never));
  WatchedCamera source(*camera, warm, hold_up);
  const RunPlan plan{.settings = settings, .title = "long", .progress = nullptr};
  require_done(run(plan, source, posix_storage()));
  CHECK(camera->end() == LiveEnd::Frames);
  const LiveCounters counters = camera->session().counters();
  CHECK(counters.captured() == frames);
  CHECK(counters.captured() == counters.emitted + counters.dropped());
  CHECK(counters.emitted > frames / 500);  // a sanitizer on a loaded machine takes a hundred times as long
  CHECK(counters.camera.contradicted == 0);
  return source.growth();
}

// The field, at whatever pace it needs: coming back from a rest it makes its networks anew.
Settings with_field() {
  Settings settings;
  settings.fit.deadline = kOff;
  return settings;
}

// The state and its governor, with the deadline of the camera.
Settings with_deadline() {
  Settings settings;
  settings.fit.emit = EmitLayer::State;
  return settings;
}

// most: allocations that are not of a frame.
void lasts(std::uint64_t frames, std::uint64_t warm, const Settings& settings, std::uint64_t most = 0) {
  const std::size_t threads = threads_of_this_process();
  const Growth growth = growth_over(frames, warm, settings);

  CHECK_ALLOCATIONS(growth.allocations <= most);
  CHECK((growth.measured || !allocations_are_counted()));        // a sanitizer's fit may be too slow
  if (allocations_are_counted()) CHECK(growth.bytes < 2 << 20);  // a sanitizer keeps what is freed
  // the kernel lists a thread for a moment after it was joined
  CHECK(test::becomes_true([&] { return threads_of_this_process() <= threads; }));
  CHECK(growth.unbalanced == 0);
  CHECK(growth.wrong_labels == 0);
}

TEST_CASE("two thousand frames of a camera cost no allocation after the first, no memory and no thread") {
  lasts(2'000, 1'000, with_field());
  // a rung that a loaded machine comes to late takes its pictures then; one a frame would be hundreds
  constexpr std::uint64_t kOfRungs = 64;
  lasts(1'000, 500, with_deadline(), kOfRungs);
}

TEST_CASE("ten thousand frames cost no more", "[.][full]") { lasts(10'000, 2'000, with_field()); }

// At 250 frames a second, more than the fit takes.
TEST_CASE("half an hour at the camera's pace costs no more", "[.][half-hour]") {
  lasts(30 * 60 * 250, 10'000, with_field());
}

}  // namespace
}  // namespace hdrcam
