// What a person may change while a camera runs: recordings and the cycle.
#include "firmware_host/live/camera_source.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <new>
#include <set>
#include <thread>

#include "firmware_host/live/live_report.h"
#include "hal/core/counted.h"
#include "hal/fault/faulty_storage.h"
#include "tests/allocations.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/becomes_true.h"
#include "tests/support/not_tested.h"
#include "tests/support/refused_threads.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

// A simulated camera whose frames are taken and emitted on a thread of their own, as a run does.
class Running {
 public:
  explicit Running(const Settings& settings)
      : source_(value_of(CameraSource::open(settings, {}, posix_storage(), stop_))) {
    require_done(source_->start());
    thread_ = std::thread([this] {
      for (;;) {
        const auto frame = source_->next();
        if (!frame || frame.value() == nullptr) return;
        const FrameFacts& facts = frame.value()->facts;
        if (facts.slot >= 0) {
          newest_gain_ = facts.analogue_gain;
          newest_exposure_us_ = std::llround(facts.exposure_s * 1e6);
        }
        FrameRecord record;
        record.sequence = facts.sequence;
        source_->emitted(record);
        ++frames_;
      }
    });
  }
  ~Running() { end(); }

  CameraSource& source() { return *source_; }
  RunControl& control() { return *source_->control(); }
  // Waits until so many more frames came; false after a long time.
  bool more_frames(int count) {
    const int wanted = frames_ + count;
    return test::becomes_true([&] { return frames_ >= wanted; });
  }
  // Waits until one of the counters has grown so much; false after a long time. Frames that were emitted may
  // have been captured long before.
  bool grows(std::uint64_t LiveCounters::*counter, std::uint64_t by) {
    const std::uint64_t wanted = source_->session().counters().*counter + by;
    return test::becomes_true([&] { return source_->session().counters().*counter >= wanted; });
  }
  long long newest_exposure_us() const { return newest_exposure_us_; }
  double newest_gain() const { return newest_gain_; }
  LiveCounters end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    RunRecord record;
    require_done(source_->finish(record));
    return source_->session().counters();
  }

 private:
  std::atomic<bool> stop_{false};
  std::unique_ptr<CameraSource> source_;
  std::atomic<int> frames_{0};
  std::atomic<long long> newest_exposure_us_{0};
  std::atomic<double> newest_gain_{0};
  std::thread thread_;
};

Settings settings_of(const std::string& folder) {
  Settings settings;
  settings.camera.id = "sim:still?size=64x48&fps=100";
  settings.camera.format = "RGB24";
  settings.schedule.shutter = "1ms,4ms";
  settings.output.http_takes = folder + "/takes/%02d.mkv";
  return settings;
}

std::vector<std::uint64_t> sequences_in(const std::string& path) {
  auto reader = value_of(open_recording(posix_storage(), path));
  std::vector<std::uint64_t> sequences;
  while (const auto facts = value_of(reader->next_facts())) sequences.push_back(facts->sequence);
  return sequences;
}

TEST_CASE(
    "recordings that a person starts and stops are whole, new files, and every frame is accounted for") {
  const std::string folder = sample::scratch_folder("takes");
  std::filesystem::create_directories(folder + "/takes");
  std::ofstream(folder + "/takes/01.mkv") << "an earlier take";
  Running run(settings_of(folder));
  RunControl& control = run.control();
  CHECK(control.recording().empty());
  require_error(control.stop_recording(), ErrorCode::NotFound);
  std::set<std::string> files;
  for (int take = 0; take < 2; ++take) {
    std::string file;
    REQUIRE(test::becomes_true([&] {  // until the last one is complete
      auto started = control.start_recording();
      if (started) file = started.value();
      return started.ok();
    }));
    CHECK(control.recording() == file);
    require_error(control.start_recording(), ErrorCode::Busy);
    REQUIRE(run.grows(&LiveCounters::recorded, 20));
    require_done(control.stop_recording());
    CHECK(control.recording().empty());
    REQUIRE(run.grows(&LiveCounters::not_requested, 5));
    files.insert(file);
  }
  const LiveCounters counters = run.end();
  CHECK(files == std::set<std::string>{folder + "/takes/02.mkv", folder + "/takes/03.mkv"});
  CHECK(value_of(read_whole(posix_storage(), folder + "/takes/01.mkv")) == "an earlier take");
  std::size_t recorded = 0;
  std::string listed;
  for (const std::string& file : files) {
    const auto sequences = sequences_in(file);
    listed += fmt::format("{}: {} frames\n", file, sequences.size());
    CHECK(sequences.size() >= 20);
    for (std::size_t i = 1; i < sequences.size(); ++i) CHECK(sequences[i] == sequences[i - 1] + 1);
    recorded += sequences.size();
  }
  CHECK(counters.recorded == recorded);
  CHECK(run.source().takes_account() == listed);
  CHECK(counters.not_requested >= 10);
  CHECK(counters.to_record == 0);
  CHECK(counters.captured() == counters.recorded + counters.not_recorded() + counters.not_requested);
}

TEST_CASE("a recording that is open when the run ends is completed") {
  const std::string folder = sample::scratch_folder("open_take");
  Running run(settings_of(folder));
  const std::string file = value_of(run.control().start_recording());
  REQUIRE(run.grows(&LiveCounters::recorded, 10));
  const LiveCounters counters = run.end();
  CHECK(sequences_in(file).size() == counters.recorded);
  CHECK(counters.recorded >= 10);
}

TEST_CASE("no recording is started once no further frame is captured, and no file is made for it") {
  const std::string folder = sample::scratch_folder("late_take");
  const std::atomic<bool> stop{false};
  const auto source =
      value_of(CameraSource::open(settings_of(folder), {.frames = 12}, posix_storage(), stop));
  require_done(source->start());
  REQUIRE(test::becomes_true([&] { return source->session().counters().ended; }));
  require_error(source->control()->start_recording(), ErrorCode::Interrupted);  // frames wait for the fit
  CHECK_FALSE(std::filesystem::exists(folder + "/takes"));
  CHECK(source->takes_account().empty());
  while (value_of(source->next()) != nullptr) continue;
  RunRecord record;
  require_done(source->finish(record));
}

TEST_CASE("a recording for which the system starts no thread is refused in a sentence, and leaves no file") {
  const std::string folder = sample::scratch_folder("take_without_thread");
  Running run(settings_of(folder));
  REQUIRE(run.more_frames(1));
  {
    const test::RefusedThreads refused;
    const auto started = run.control().start_recording();
    require_error(started, ErrorCode::Io);
    CHECK(started.error().message.find("starts no further thread") != std::string::npos);
  }
  CHECK(std::filesystem::is_empty(folder + "/takes"));
  CHECK(run.control().recording().empty());
  CHECK(value_of(run.control().start_recording()) == folder + "/takes/01.mkv");
}

TEST_CASE("a recording for which memory ends as it is started leaves no file, and the run goes on") {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer brings operators of its own, and memory cannot be made to end");
    return;
  }
  const std::string folder = sample::scratch_folder("take_without_memory");
  Running run(settings_of(folder));
  REQUIRE(run.more_frames(1));
  {
    const EndOfMemory end_of_memory(16 << 10);  // less than the recorder's queue for 4096 frames
    CHECK_THROWS_AS(run.control().start_recording(), std::bad_alloc);
  }
  CHECK(std::filesystem::is_empty(folder + "/takes"));
  CHECK(run.control().recording().empty());
  REQUIRE(run.more_frames(1));
  CHECK(value_of(run.control().start_recording()) == folder + "/takes/01.mkv");
}

TEST_CASE("frames of recordings that a person starts are not said to be in that of the run") {
  const std::string folder = sample::scratch_folder("own_and_takes");
  Settings settings = settings_of(folder);
  settings.record.file = folder + "/run.mkv";
  Running run(settings);
  REQUIRE(run.more_frames(10));
  require_done(run.control().stop_recording());
  std::string take;
  REQUIRE(test::becomes_true([&] {  // until the run's own is complete
    auto started = run.control().start_recording();
    if (started) take = started.value();
    return started.ok();
  }));
  REQUIRE(run.grows(&LiveCounters::in_takes, 10));
  LiveCounters counters = run.end();
  CHECK(counters.in_takes == sequences_in(take).size());
  CHECK(run.source().takes_account() == fmt::format("{}: {} frames\n", take, counters.in_takes));
  CHECK(counters.recorded - counters.in_takes == sequences_in(settings.record.file).size());
  CHECK(counters.in_takes >= 10);
  counters.shed = 1;
  CHECK(advice_to_keep_up(counters, settings, {}).find("all frames are recorded") == std::string::npos);
}

TEST_CASE(
    "a recording that a person starts and a full disk cuts is said to be so, with how many frames it has") {
  const std::string folder = sample::scratch_folder("cut_take");
  FaultyStorage full(posix_storage(), {.space_bytes = 40'000});
  const std::atomic<bool> stop{false};
  const auto source = value_of(CameraSource::open(settings_of(folder), {}, full, stop));
  require_done(source->start());
  const std::string take = value_of(source->control()->start_recording());
  while (value_of(source->next()) != nullptr) continue;
  RunRecord record;
  const Result<void> ended = source->finish(record);
  require_error(ended, ErrorCode::NoSpace);
  const std::uint64_t frames = source->session().counters().in_takes;
  CHECK(frames >= 1);
  CHECK_THAT(ended.error().message,
             Catch::Contains(fmt::format("'{0}' is cut after {1}, of which 'hdrcam repair {0} -o FILE'", take,
                                         counted(frames, "frame"))));
}

TEST_CASE("a recording that a person starts and stops between two frames is named, for its file is there") {
  Settings settings = settings_of(sample::scratch_folder("take_between_frames"));
  settings.camera.id = "sim:still?size=64x48&fps=2";
  Running run(settings);
  REQUIRE(run.more_frames(1));
  const std::string take = value_of(run.control().start_recording());
  require_done(run.control().stop_recording());
  const LiveCounters counters = run.end();
  CHECK(sequences_in(take).size() == counters.in_takes);  // 0 unless the machine is very slow
  CHECK(run.source().takes_account().starts_with(take + ": "));
}

TEST_CASE("a run without a place for recordings records nothing on demand, and says how to get one") {
  Settings settings = settings_of("unused");
  settings.output.http_takes.clear();
  Running run(settings);
  const auto refused = run.control().start_recording();
  require_error(refused, ErrorCode::Unsupported);
  CHECK(refused.error().message.find("--http-record") != std::string::npos);
  CHECK(run.source().takes_account().empty());
}

TEST_CASE("the cycle of a running camera changes to one of as many exposures, and to no other") {
  Running run(settings_of("unused"));
  REQUIRE(run.more_frames(10));
  require_done(run.control().change_cycle("2ms,8ms", ""));
  CHECK(test::becomes_true([&] { return std::abs(run.newest_exposure_us() - 8000) < 100; }));
  CHECK(test::becomes_true([&] { return std::abs(run.newest_exposure_us() - 2000) < 100; }));
  require_error(run.control().change_cycle("1ms,4ms,16ms", ""), ErrorCode::Invalid);
  require_error(run.control().change_cycle("fast", ""), ErrorCode::Invalid);
  REQUIRE_FALSE(run.control().change_cycle("2ms,1s", "").ok());
  REQUIRE(run.more_frames(10));
  CHECK(test::becomes_true([&] { return std::abs(run.newest_exposure_us() - 8000) < 100; }));
  CHECK(run.source().session().counters().camera.cycle_changes == 1);  // the refused ones are none
}

TEST_CASE("a cycle that is changed without a gain keeps the one that it has") {
  Settings settings = settings_of("unused");
  settings.schedule.gain = "2";
  Running run(settings);
  REQUIRE(run.more_frames(10));
  const auto follows = [&](const char* shutter, const char* gain, long long exposure_us, double expected) {
    INFO(shutter << " " << gain);
    require_done(run.control().change_cycle(shutter, gain));
    CHECK(test::becomes_true([&] { return std::abs(run.newest_exposure_us() - exposure_us) < 100; }));
    CHECK(run.newest_gain() == Approx(expected));
  };
  follows("1ms,6ms", "", 6000, 2);
  follows("1ms,5ms", "3", 5000, 3);
  follows("1ms,7ms", "", 7000, 3);
  follows("1ms,6ms", "2,2", 6000, 2);
  const auto more = run.control().change_cycle("1ms,4ms,16ms", "");
  require_error(more, ErrorCode::Invalid);
  CHECK(more.error().message.find("the cycle of this run has 2 exposures, not 3") != std::string::npos);
}

TEST_CASE("a cycle that follows the light is not changed by hand") {
  Settings settings = settings_of("unused");
  settings.schedule.adapt = Adapt::Light;
  Running run(settings);
  require_error(run.control().change_cycle("2ms,8ms", ""), ErrorCode::Unsupported);
}

TEST_CASE("exposures that the fit asks for are those of later frames, and counted") {
  Settings settings = settings_of("unused");
  CHECK_FALSE(Running(settings).source().exposure_limits());
  settings.schedule.adapt = Adapt::Motion;
  Running run(settings);
  const auto limits = run.source().exposure_limits();
  REQUIRE(limits);
  CHECK(limits->cycle == std::vector<Exposure>{{milliseconds(1), 1}, {milliseconds(4), 1}});
  CHECK(limits->longest < milliseconds(10));
  CHECK(limits->greatest_gain > 1);
  require_done(run.source().follow({{milliseconds(2), 1}, {milliseconds(6), 1}}));
  REQUIRE(test::becomes_true([&] { return run.newest_exposure_us() == 6000; }));
  require_error(run.source().follow({{milliseconds(2), 1}, {std::chrono::seconds(1), 1}}),
                ErrorCode::BadExposure);
  REQUIRE(run.more_frames(10));
  require_error(run.control().change_cycle("2ms,8ms", ""), ErrorCode::Unsupported);
  const LiveCounters counters = run.end();
  CHECK(run.source().accounts() ==
        std::vector<std::string>{"the motion changed the cycle 1 time; last to 2 ms, 6 ms"});
  CHECK(counters.camera.cycle_changes == 1);
  CHECK(counters.camera.contradicted == 0);
}

TEST_CASE("a strobe line that has a pulse for no frame is told of, with what to check") {
  for (const std::string delay : {"0us", "10ms"}) {  // at the pulses of 50 frames a second, and between them
    INFO(delay);
    Settings settings;
    settings.camera.id = "sim:still?size=64x48&rays=1&fps=50";
    settings.camera.format = "RGB24";
    settings.schedule.shutter = "1ms,4ms";
    settings.sync.line = "sim";
    settings.sync.strobe_delay = delay;
    const std::atomic<bool> stop{false};
    const auto source = value_of(CameraSource::open(settings, {.frames = 12}, posix_storage(), stop));
    require_done(source->start());
    while (value_of(source->next()) != nullptr) continue;
    RunRecord record;
    require_done(source->finish(record));
    const bool marks = delay == "0us";
    CHECK((source->session().counters().camera.strobed > 0) == marks);
    CHECK(source->accounts().empty() == marks);
    REQUIRE(record.notes.size() == (marks ? 1 : 2));
    if (!marks) CHECK_THAT(record.notes[1], Catch::Contains("'sim'") && Catch::Contains("--strobe-delay"));
  }
}

TEST_CASE("a strobe line whose pulses are those of other frames is told of, with what to check") {
  for (const std::string delay :
       {"0us", "-20ms"}) {  // at the pulses of 50 frames a second, and one frame off
    INFO(delay);
    Settings settings;
    settings.camera.id = "sim:still?size=64x48&rays=1&fps=50";
    settings.camera.format = "RGB24";
    settings.schedule.shutter = "1ms,4ms,12ms";
    settings.sync.line = "sim";
    settings.sync.strobe = StrobePulse::SpansExposure;
    settings.sync.strobe_delay = delay;
    const std::atomic<bool> stop{false};
    const auto source = value_of(CameraSource::open(settings, {.frames = 40}, posix_storage(), stop));
    require_done(source->start());
    while (value_of(source->next()) != nullptr) continue;
    RunRecord record;
    require_done(source->finish(record));
    const bool fits = delay == "0us";
    REQUIRE(record.notes.size() == (fits ? 1 : 2));
    CHECK((source->session().counters().camera.strobe_misfits < 8) == fits);
    if (!fits)
      CHECK_THAT(record.notes[1], Catch::Contains("of 40 frames are not as long as their exposures") &&
                                      Catch::Contains("--strobe-delay"));
  }
}

TEST_CASE("pictures of another size than the one asked for are told of") {
  Settings settings = settings_of("unused");
  settings.camera.format = "RGGB8";  // whose sides are even
  const std::atomic<bool> stop{false};
  for (const int width : {64, 65}) {
    settings.camera.width = width;
    const auto source = value_of(CameraSource::open(settings, {.frames = 1}, posix_storage(), stop));
    const auto all = source->warnings();
    const auto told = std::ranges::count_if(all, [](const std::string& note) {
      return note.find("gives pictures of 64x48, the nearest to --width") != std::string::npos;
    });
    CHECK(told == (width == 64 ? 0 : 1));
  }
}

TEST_CASE("a camera without pictures as small as asked for is admitted by the size of those that it has") {
  const std::string path = sample::scratch_folder("camera_admitted") + "/large.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 640, 480);
  std::vector<RawFrame> frames = sample::frames(camera, 12, 1);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameFacts& facts = frames[i].facts = {};
    facts.sequence = i;
    facts.timestamp = Instant::from_seconds(static_cast<double>(i) / 30);
    facts.exposure_s = i % 2 == 0 ? 0.001 : 0.004;
  }
  require_done(sample::record(posix_storage(), path, camera, frames));
  Settings settings;
  settings.camera.id = "replay:" + path;
  settings.camera.width = 32, settings.camera.height = 24;
  settings.record.memory_mib = 1;
  const std::atomic<bool> stop{false};
  const auto opened = [&](int memory_mib) {
    settings.machine.memory_mib = memory_mib;
    return CameraSource::open(settings, {.work = LiveWork::RecordOnly}, posix_storage(), stop);
  };
  const auto refused = opened(84);
  require_error(refused, ErrorCode::Unsupported);
  CHECK(refused.error().message.starts_with("a stream of 640x480 needs about"));
  CHECK(opened(160).ok());
}

TEST_CASE("a run that follows the light notes how often, and its last cycle") {
  Settings settings;
  settings.camera.id = "sim:walk?size=64x48&rays=1&fps=50";  // its highlights clip at 1 ms
  settings.camera.format = "RGB24";
  settings.schedule.shutter = "1ms,4ms";
  settings.schedule.adapt = Adapt::Light;
  const std::atomic<bool> stop{false};
  const auto source = value_of(CameraSource::open(settings, {.frames = 60}, posix_storage(), stop));
  require_done(source->start());
  while (value_of(source->next()) != nullptr) continue;
  RunRecord record;
  require_done(source->finish(record));
  const std::uint64_t changes = source->session().counters().camera.cycle_changes;
  REQUIRE(changes > 0);
  REQUIRE(record.notes.size() == 2);
  CHECK(record.notes[1] == fmt::format("the light changed the cycle {}; last to {}", counted(changes, "time"),
                                       describe(source->capture().schedule().cycle())));
  CHECK_THAT(record.notes[1], !Catch::Contains("last to 1 ms, 4 ms"));
}

TEST_CASE("a single exposure has no ends that the light could move") {
  Settings settings = settings_of("unused");
  settings.schedule.shutter = "4ms";
  settings.schedule.adapt = Adapt::Light;
  const std::atomic<bool> never{false};
  for (const LiveWork work : {LiveWork::Fit, LiveWork::RecordOnly}) {
    const auto refused = CameraSource::open(settings, {.work = work}, posix_storage(), never);
    require_error(refused, ErrorCode::Invalid);
    CHECK_THAT(refused.error().message, Catch::Contains("--shutter 1ms,4ms,16ms"));
  }
  settings.schedule.gain = "1,4";  // for each exposure of the cycle, whose time is one
  CHECK(CameraSource::open(settings, {}, posix_storage(), never).ok());
}

TEST_CASE("a run that only records has no fit to ask for exposures") {
  Settings settings = settings_of("unused");
  settings.schedule.adapt = Adapt::Motion;
  const std::atomic<bool> never{false};
  require_error(CameraSource::open(settings, {.work = LiveWork::RecordOnly}, posix_storage(), never),
                ErrorCode::Invalid);
}

}  // namespace
}  // namespace hdrcam
