#include "firmware_host/live/live_session.h"

#include "firmware_host/live/live_report.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <set>
#include <thread>
#include <utility>

#include "hal/fault/faulty_camera.h"
#include "hal/fault/faulty_storage.h"
#include "hal/sim/sim_bench.h"
#include "tests/firmware_host/live/writer_without_memory.h"
#include "tests/support/becomes_true.h"
#include "tests/support/scratch_folder.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;
const std::atomic<bool> kNeverStops{false};

std::unique_ptr<CaptureStage> capture_of(Camera& camera, const Simulation& simulation,
                                         const std::vector<Exposure>& cycle) {
  CaptureOptions options;
  options.mode = {PixelFormat::Rgb24, simulation.width, simulation.height, simulation.frame_duration()};
  return value_of(CaptureStage::open(camera, nullptr, cycle, Mains::Off, options));
}

const std::vector<Exposure> kCycle{{milliseconds(1), 1}, {milliseconds(4), 1}};

// A camera, its capture and a place for a recording.
class Stand {
 public:
  explicit Stand(const std::string& scene, const std::vector<Exposure>& cycle = kCycle)
      : simulation_(value_of(simulation_of(scene))),
        camera_(simulation_, SimTime(), 1),
        capture_(capture_of(camera_, simulation_, cycle)) {}
  CaptureStage& capture() { return *capture_; }
  SimulatedCamera& camera() { return camera_; }

  std::unique_ptr<RecordingWriter> record(Storage& storage) {
    return value_of(create_recording(storage, path_, capture_->facts()));
  }
  // The facts of what was recorded.
  std::vector<FrameFacts> recorded() const {
    auto reader = value_of(open_recording(posix_storage(), path_));
    std::vector<FrameFacts> frames;
    for (;;) {
      auto facts = reader->next_facts();
      if (!facts) require_error(facts, ErrorCode::Truncated);
      if (!facts || !*facts) return frames;
      frames.push_back(**facts);
    }
  }
  const std::string& path() const { return path_; }
  void remove_recording() const { std::filesystem::remove(path_); }

 private:
  const std::string path_ = test::scratch_folder("live_session") + "/raw.mkv";
  Simulation simulation_;
  SimulatedCamera camera_;
  std::unique_ptr<CaptureStage> capture_;
};

// Memory ends while it waits for the frame behind so many.
class CameraWithoutMemory : public FaultyCamera {
 public:
  CameraWithoutMemory(std::unique_ptr<Camera> inner, std::uint64_t frames)
      : FaultyCamera(std::move(inner), {}), frames_(frames) {}
  Result<CapturedBuffer> wait(Duration timeout) override {
    if (delivered() == frames_) throw std::bad_alloc();
    return FaultyCamera::wait(timeout);
  }

 private:
  const std::uint64_t frames_;
};

// Memory ends once, between two frames, where the capturing thread changes the cycle.
class CameraWithoutMemoryForCycle : public FaultyCamera {
 public:
  explicit CameraWithoutMemoryForCycle(std::unique_ptr<Camera> inner) : FaultyCamera(std::move(inner), {}) {}
  void end_memory() { ends_ = true; }

  const CameraCapabilities& capabilities() const override {
    if (between_frames_ && ends_.exchange(false)) throw std::bad_alloc();
    return FaultyCamera::capabilities();
  }
  Result<void> queue(const ExposureRequest& request) override {
    between_frames_ = true;
    return FaultyCamera::queue(request);
  }
  Result<CapturedBuffer> wait(Duration timeout) override {
    Result<CapturedBuffer> waited = FaultyCamera::wait(timeout);
    between_frames_ = false;  // until the request for the next one
    return waited;
  }

 private:
  mutable std::atomic<bool> ends_{false};
  bool between_frames_ = false;
};

// Delivers nothing; a wait takes a quarter of its time.
class SilentCamera : public FaultyCamera {
 public:
  explicit SilentCamera(std::unique_ptr<Camera> inner) : FaultyCamera(std::move(inner), {}) {}
  Result<CapturedBuffer> wait(Duration timeout) override {
    waits_ = true;
    std::this_thread::sleep_for(timeout / 4);
    return Error{ErrorCode::Timeout, "no frame came"};
  }
  bool waits() const { return waits_; }

 private:
  std::atomic<bool> waits_{false};
};

void check_sums(const LiveCounters& counters) {
  CHECK(counters.captured() == counters.emitted + counters.dropped() + counters.in_fit);
  CHECK(counters.camera.captured == counters.camera.emitted + counters.camera.dropped());
}

TEST_CASE(
    "a run says how many frames were taken too late for their pulses, and how many exposures were late") {
  LiveCounters counters;
  counters.camera.pulses_forgotten = 3, counters.camera.controls_late = 5;
  const std::vector<NamedValue> list = named(counters);
  for (const auto& [name, value] : {std::pair{"camera.pulses_forgotten", 3}, {"camera.controls_late", 5}}) {
    const auto counted = std::ranges::find(list, name, &NamedValue::name);
    REQUIRE(counted != list.end());
    CHECK(counted->value == value);
  }
  CHECK(proof_of(counters.camera).ends_with("pulses: 3; frames whose exposure was written late or never: 5"));
}

TEST_CASE(
    "with a camera twice as fast as the fit the recording is complete and every frame is accounted for") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), stand.record(posix_storage()), {.frames = 800});
  require_done(session.start(kNeverStops));
  std::atomic<bool> watching{true};
  int looks = 0, wrong_sums = 0;
  std::thread watcher([&] {
    for (; watching; ++looks) {
      const LiveCounters now = session.counters();
      wrong_sums += now.captured() != now.emitted + now.dropped() + now.in_fit;
      wrong_sums += now.captured() != now.recorded + now.pool_full + now.to_record + now.camera.dropped();
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  std::set<int> slots;
  Duration oldest{0};
  while (const FrameShare frame = session.next({})) {
    std::this_thread::sleep_for(milliseconds(10));  // the fit
    slots.insert(frame->captured.raw.facts.slot);
    oldest = std::max(oldest, session.emitted(frame->captured.raw.facts.sequence));
  }
  CHECK(value_of(session.finish()) == LiveEnd::Frames);
  watching = false;
  watcher.join();
  CHECK(looks > 100);
  CHECK(wrong_sums == 0);
  const LiveCounters counters = session.counters();
  check_sums(counters);
  CHECK(counters.in_fit == 0);
  CHECK(counters.to_record == 0);
  CHECK(counters.captured() == 800);
  CHECK(counters.shed >= 200);  // frames wait until there are 200 of them, a second's
  CHECK(counters.pool_full == 0);
  CHECK(slots.size() == 2);
  CHECK(oldest <
        milliseconds(2500));  // a second's, on a busy machine more; with a queue that only grows, four
  CHECK(counters.longest_latency == oldest);
  const auto frames = stand.recorded();
  CHECK(frames.size() == 800);
  for (std::size_t i = 1; i < frames.size(); ++i) CHECK(frames[i].sequence > frames[i - 1].sequence);
}

TEST_CASE("a run says that no further frame is captured while its fit still has frames") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), nullptr, {.frames = 5});
  CHECK_FALSE(session.counters().ended);
  require_done(session.start(kNeverStops));
  REQUIRE(test::becomes_true([&] { return session.counters().ended; }));
  const LiveCounters now = session.counters();
  CHECK(now.captured() == 5);
  CHECK(now.waiting() > 0);
}

TEST_CASE("a recording is complete once no further frame is captured, though the fit has taken none") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), stand.record(posix_storage()), {.frames = 10});
  require_done(session.start(kNeverStops));
  REQUIRE(test::becomes_true([&] { return session.counters().ended; }));
  CHECK(test::becomes_true([&] {
    const auto reader = open_recording(posix_storage(), stand.path());
    return reader && reader.value()->frame_count() == 10;
  }));
  CHECK(session.counters().waiting() > 0);
  CHECK(value_of(session.finish()) == LiveEnd::Frames);
}

TEST_CASE("a run that only records hands out no frame and keeps them all") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), stand.record(posix_storage()),
                      {.frames = 60, .work = LiveWork::RecordOnly});
  require_done(session.start(kNeverStops));
  CHECK_FALSE(session.next({}));
  CHECK(value_of(session.finish()) == LiveEnd::Frames);
  const LiveCounters counters = session.counters();
  CHECK(counters.captured() == 60);
  CHECK(counters.recorded == 60);
  CHECK(counters.dropped() == 0);
  CHECK(stand.recorded().size() == 60);
}

TEST_CASE("a run ends when its time is up, and when it is told to") {
  for (const bool told : {false, true}) {
    Stand stand("still?size=64x48&fps=200");
    std::atomic<bool> stop{false};
    LiveSession session(stand.capture(), nullptr,
                        {.timeout = told ? Duration(0) : Duration(milliseconds(600))});
    require_done(session.start(stop));
    int frames = 0;
    while (const FrameShare frame = session.next({})) {
      session.emitted(frame->captured.raw.facts.sequence);
      if (++frames == 20 && told) stop = true;
    }
    CHECK(value_of(session.finish()) == (told ? LiveEnd::Stopped : LiveEnd::Timeout));
    CHECK(frames >= 10);
    check_sums(session.counters());
  }
}

TEST_CASE("a run on a slow camera that delivers no frame ends when it is told to, not when it gives up") {
  const Simulation simulation = value_of(simulation_of("still?size=64x48&fps=1"));
  SilentCamera camera(std::make_unique<SimulatedCamera>(simulation, SimTime(), 1));
  CaptureOptions options;
  options.mode = {PixelFormat::Rgb24, simulation.width, simulation.height, simulation.frame_duration()};
  options.patience = std::chrono::seconds(10);
  const auto capture = value_of(CaptureStage::open(camera, nullptr, kCycle, Mains::Off, options));
  std::atomic<bool> stop{false};
  LiveSession session(*capture, nullptr, {});
  require_done(session.start(stop));
  CHECK(test::becomes_true([&] { return camera.waits(); }));
  stop = true;
  while (session.next({})) {
  }
  CHECK(value_of(session.finish()) == LiveEnd::Stopped);
}

TEST_CASE("who asks for a cycle while a run ends hears so with its last frame, not after seconds") {
  const std::vector<Exposure> cycle{{milliseconds(2), 1}, {milliseconds(8), 1}};
  Stand stand("still?size=64x48&fps=2");
  std::atomic<bool> stop{false};
  LiveSession session(stand.capture(), nullptr, {});
  require_done(session.start(stop));
  REQUIRE(session.next({}));
  std::this_thread::sleep_for(milliseconds(100));  // capture waits for the next frame, which is the last
  stop = true;
  require_error(session.change_cycle(cycle), ErrorCode::Interrupted);
  while (session.next({})) {
  }
  require_error(session.change_cycle(cycle), ErrorCode::Interrupted);
  CHECK(value_of(session.finish()) == LiveEnd::Stopped);
}

TEST_CASE("what a change of the cycle throws reaches who asked for it, and the run goes on") {
  const std::vector<Exposure> cycle{{milliseconds(2), 1}, {milliseconds(6), 1}};
  const Simulation simulation = value_of(simulation_of("still?size=64x48&fps=100"));
  CameraWithoutMemoryForCycle camera(std::make_unique<SimulatedCamera>(simulation, SimTime(), 1));
  const auto capture = capture_of(camera, simulation, kCycle);
  std::atomic<bool> stop{false};
  LiveSession session(*capture, nullptr, {});
  require_done(session.start(stop));
  camera.end_memory();
  CHECK_THROWS_AS(session.change_cycle(cycle), std::bad_alloc);
  CHECK(capture->schedule().slot(0).asked.time == kCycle.front().time);
  const std::uint64_t captured = session.counters().captured();
  require_done(session.change_cycle(cycle));
  CHECK(test::becomes_true([&] { return session.counters().captured() > captured; }));
  stop = true;
  while (session.next({})) {
  }
  CHECK(value_of(session.finish()) == LiveEnd::Stopped);
}

TEST_CASE("a run ends at its time, when it is told to and with a full disk, however busy the fit is") {
  constexpr std::uint64_t kFrames = 100;  // at most; twice as many come while the fit has its first frame
  const auto busy_fit = [](LiveSession& session, const std::atomic<bool>& stop,
                           const std::function<void()>& begins) {
    require_done(session.start(stop));
    bool first = true;
    while (const FrameShare frame = session.next({})) {
      if (std::exchange(first, false)) {
        begins();
        std::this_thread::sleep_for(std::chrono::seconds(1));
      }
      session.emitted(frame->captured.raw.facts.sequence);
    }
  };
  Stand stand("still?size=64x48&fps=200");
  std::atomic<bool> stop{false};
  SECTION("its time") {
    LiveSession session(stand.capture(), nullptr, {.timeout = milliseconds(100)});
    busy_fit(session, stop, [] {});
    CHECK(value_of(session.finish()) == LiveEnd::Timeout);
    CHECK(session.counters().captured() <= kFrames);
    check_sums(session.counters());
  }
  SECTION("it is told to") {
    LiveSession session(stand.capture(), nullptr, {});
    std::uint64_t captured = 0;
    busy_fit(session, stop, [&] { stop = true, captured = session.counters().captured(); });
    CHECK(value_of(session.finish()) == LiveEnd::Stopped);
    CHECK(session.counters().captured() <= captured + kFrames);
    check_sums(session.counters());
  }
  SECTION("a full disk") {
    FaultyStorage storage(posix_storage(), {.space_bytes = 40'000});
    LiveSession session(stand.capture(), stand.record(storage), {});
    busy_fit(session, stop, [] {});
    require_error(session.finish(), ErrorCode::NoSpace);
    CHECK(session.counters().captured() <= kFrames);
    check_sums(session.counters());
  }
}

TEST_CASE("a camera that is unplugged ends the run with all that it gave, fitted and recorded") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), stand.record(posix_storage()), {});
  require_done(session.start(kNeverStops));
  int frames = 0;
  while (const FrameShare frame = session.next({})) {
    session.emitted(frame->captured.raw.facts.sequence);
    if (++frames == 30) SimBench(stand.camera()).unplug();
  }
  require_error(session.finish(), ErrorCode::Unplugged);
  const LiveCounters counters = session.counters();
  check_sums(counters);
  CHECK(counters.in_fit == 0);
  CHECK(counters.recorded == counters.captured());
  CHECK(stand.recorded().size() == counters.recorded);
}

TEST_CASE("a full disk ends the run with that error, and what was recorded before can be read") {
  Stand stand("still?size=64x48&fps=200");
  FaultyStorage storage(posix_storage(), {.space_bytes = 40'000});
  LiveSession session(stand.capture(), stand.record(storage), {});
  require_done(session.start(kNeverStops));
  while (const FrameShare frame = session.next({})) session.emitted(frame->captured.raw.facts.sequence);
  require_error(session.finish(), ErrorCode::NoSpace);
  CHECK(stand.recorded().size() >= session.counters().recorded);
  CHECK(session.counters().recorded > 1);
}

TEST_CASE("the ledger of a recording adds up when the disk fills: what was not written counts as dropped") {
  Stand stand("still?size=64x48&fps=200");
  FaultyStorage storage(posix_storage(), {.space_bytes = 40'000});
  LiveSession session(stand.capture(), stand.record(storage), {.work = LiveWork::RecordOnly});
  require_done(session.start(kNeverStops));
  CHECK_FALSE(session.next({}));
  require_error(session.finish(), ErrorCode::NoSpace);
  const LiveCounters counters = session.counters();
  CHECK(counters.recorded > 1);
  CHECK(counters.unwritten > 0);
  CHECK(counters.to_record == 0);
  CHECK(counters.captured() == counters.recorded + counters.not_recorded());
  const std::string said = sentence_of(counters, LiveWork::RecordOnly);
  INFO(said);
  CHECK(said.find(fmt::format("captured {} = recorded {} + dropped {}", counters.captured(),
                              counters.recorded, counters.captured() - counters.recorded)) == 0);
  CHECK(said.find("not written, the recording failed") != std::string::npos);
}

TEST_CASE(
    "what a recording throws ends the run and is thrown at its end, and the frames before it are whole") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(),
                      std::make_unique<test::WriterWithoutMemory>(stand.record(posix_storage()), 20),
                      {.work = LiveWork::RecordOnly});
  require_done(session.start(kNeverStops));
  CHECK_FALSE(session.next({}));
  CHECK_THROWS_AS(session.finish(), std::bad_alloc);
  const LiveCounters counters = session.counters();
  CHECK(counters.recorded == 20);
  CHECK(counters.captured() == counters.recorded + counters.not_recorded());
  CHECK(value_of(open_recording(posix_storage(), stand.path()))->frame_count() == 20);
  CHECK(stand.recorded().size() == 20);
}

TEST_CASE("what a camera throws ends the run with all that it gave before, fitted and recorded") {
  const std::string path = test::scratch_folder("live_session_camera_throws") + "/raw.mkv";
  const Simulation simulation = value_of(simulation_of("still?size=64x48&fps=200"));
  CameraWithoutMemory camera(std::make_unique<SimulatedCamera>(simulation, SimTime(), 1), 30);
  const auto capture = capture_of(camera, simulation, kCycle);
  LiveSession session(*capture, value_of(create_recording(posix_storage(), path, capture->facts())), {});
  require_done(session.start(kNeverStops));
  while (const FrameShare frame = session.next({})) session.emitted(frame->captured.raw.facts.sequence);
  CHECK_THROWS_AS(session.finish(), std::bad_alloc);
  const LiveCounters counters = session.counters();
  check_sums(counters);
  CHECK(counters.ended);
  CHECK(counters.emitted > 0);
  CHECK(counters.recorded > 0);
  CHECK(counters.recorded == counters.captured());
  CHECK(value_of(open_recording(posix_storage(), path))->frame_count() ==
        static_cast<int>(counters.recorded));
}

TEST_CASE("a recording that failed while it was completed keeps its error, and no new one hides it") {
  Stand stand("still?size=64x48&fps=200");
  FaultyStorage storage(posix_storage(), {.space_bytes = 40'000});
  LiveSession session(stand.capture(), stand.record(storage), {.work = LiveWork::RecordOnly});
  require_done(session.start(kNeverStops));
  CHECK_FALSE(session.next({}));  // until the recorder has failed
  require_done(session.stop_recording());
  Result<void> allowed;
  REQUIRE(test::becomes_true([&] {
    allowed = session.may_record();
    return allowed || allowed.error().code != ErrorCode::Busy;
  }));
  require_error(allowed, ErrorCode::NoSpace);
  stand.remove_recording();
  require_error(session.start_recording(stand.record(posix_storage())), ErrorCode::NoSpace);
  require_error(session.finish(), ErrorCode::NoSpace);
}

TEST_CASE("a recording that was stopped is let go of while the run goes on") {
  Stand stand("still?size=64x48&fps=200");
  LiveSession session(stand.capture(), stand.record(posix_storage()), {});
  require_done(session.start(kNeverStops));
  REQUIRE(test::becomes_true([&] { return session.counters().recorded > 0; }));
  require_error(value_of(posix_storage().open(stand.path()))->hold(), ErrorCode::Busy);
  require_done(session.stop_recording());
  REQUIRE(test::becomes_true([&] { return session.may_record().ok(); }));
  require_done(value_of(posix_storage().open(stand.path()))->hold());
}

TEST_CASE("frames whose exposure is not proved are recorded, but kept out of the fit") {
  Stand stand("still?size=64x48&fps=200&reports=no");
  LiveSession session(stand.capture(), stand.record(posix_storage()), {.frames = 60});
  require_done(session.start(kNeverStops));
  while (const FrameShare frame = session.next({})) {
    CHECK((frame->captured.raw.facts.flags & kFrameExposureUnproved) == 0);
    session.emitted(frame->captured.raw.facts.sequence);
  }
  CHECK(value_of(session.finish()) == LiveEnd::Frames);
  const LiveCounters counters = session.counters();
  CHECK(counters.unproved > 0);
  CHECK(counters.recorded == 60);
  check_sums(counters);
}

}  // namespace
}  // namespace hdrcam
