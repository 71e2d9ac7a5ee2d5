#include "firmware_host/run/run.h"

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "firmware_host/run/pipeline_options.h"
#include "firmware_host/run/record_keeping.h"
#include "tests/contracts/expect.h"
#include "tests/support/moving_scene.h"

namespace hdrcam {
namespace {

// A clip in memory, which may end with an error.
class MemorySource : public FrameSource {
 public:
  MemorySource(int frames, Result<void> end, const test::MovingScene& scene = {})
      : scene_(scene), end_(std::move(end)) {
    for (int i = 0; i < frames; ++i) frames_.push_back(scene_.frame(i));
    camera_ = scene_.camera();
  }
  const CameraFacts& camera() const override { return camera_; }
  RunPace pace() const override { return RunPace::Clip; }
  Result<const RawFrame*> next() override {
    return next_ < frames_.size() ? &frames_[next_++] : static_cast<const RawFrame*>(nullptr);
  }
  void emitted(FrameRecord& record) override { record.latency_ms = 7; }
  void left_out() override { ++left_out_; }
  void learn_response(const Response::Curve&, const BlackLevel&) override { ++responses_; }
  Result<void> finish(RunRecord& record) override {
    record.notes.emplace_back("from the source");
    return end_;
  }
  void state_poses(std::size_t from) {
    for (std::size_t i = from; i < frames_.size(); ++i)
      frames_[i].facts.T_world_camera = pose_matrix_of(RigidTransform{});
  }
  int responses() const { return responses_; }
  int left_out_frames() const { return left_out_; }

 private:
  const test::MovingScene scene_;
  CameraFacts camera_;
  std::vector<RawFrame> frames_;
  std::size_t next_ = 0;
  Result<void> end_;
  int responses_ = 0, left_out_ = 0;
};

// What the run handed to a sink of this test.
struct Seen {
  std::vector<std::uint64_t> sequences;
  std::vector<double> latencies_ms;
  bool inputs_fit = true;
  bool finished = false;
  std::optional<RunRecord> record;
} seen;

class SeeingSink : public FrameSink {
 public:
  Result<void> emit(const EmittedFrame& frame) override {
    if (failing) return Error{ErrorCode::NoSpace, "the disk is full"};
    seen.sequences.push_back(frame.hdr.facts.sequence);
    seen.latencies_ms.push_back(frame.record.latency_ms);
    seen.inputs_fit = seen.inputs_fit && frame.input.facts.sequence == frame.hdr.facts.sequence &&
                      frame.record.sequence == frame.hdr.facts.sequence;
    return {};
  }
  Result<void> finish() override { return seen.finished = true, Result<void>{}; }
  Result<void> conclude(const RunRecord& record) override { return seen.record = record, conclusion; }

  static inline bool failing = false;
  static inline Result<void> conclusion = {};
};

class LightSinkWithoutMemory : public FrameSink {
 public:
  Result<void> emit(const EmittedFrame&) override { throw std::bad_alloc(); }
};

constexpr SinkKind kKinds[] = {{"seen", "--seen", "what this test sees", SinkPace::Complete,
                                SinkTarget::Files,
                                [](const SinkRequest&) -> Result<std::unique_ptr<FrameSink>> {
                                  return std::unique_ptr<FrameSink>(std::make_unique<SeeingSink>());
                                }}};

RunPlan plan() {
  seen = {};
  SeeingSink::failing = false, SeeingSink::conclusion = {};
  RunPlan plan{.settings = {}, .title = "a title", .sinks = kKinds, .progress = nullptr};
  plan.settings.fit.preset = Preset::Fast;
  plan.settings.fit.emit = EmitLayer::State;
  plan.settings.fit.threads = 1;
  plan.settings.output.paths["seen"] = "here";
  return plan;
}

TEST_CASE("a run hands each HDR frame with its input and its record to the sinks, then the whole record") {
  MemorySource source(9, {});
  require_done(run(plan(), source, posix_storage()));
  CHECK(seen.sequences.size() == 9);
  CHECK(std::is_sorted(seen.sequences.begin(), seen.sequences.end()));
  CHECK(seen.inputs_fit);
  CHECK(std::count(seen.latencies_ms.begin(), seen.latencies_ms.end(), 7) == 9);
  REQUIRE(seen.record);
  CHECK(seen.record->title == "a title");
  CHECK(seen.record->captured == 9);
  CHECK(seen.record->emitted == 9);
  REQUIRE(seen.record->frames.size() == 9);
  for (const FrameRecord& frame : seen.record->frames) {
    REQUIRE_FALSE(frame.stages_ms.empty());
    CHECK((frame.stages_ms.end() - 1)->name == "sinks");
    double sum_ms = 0;
    for (const NamedValue& stage : frame.stages_ms) sum_ms += stage.value;
    CHECK(frame.total_ms == Approx(sum_ms));
  }
  REQUIRE(seen.record->sinks.size() == 1);
  CHECK(seen.record->sinks[0].frames == 9);
  CHECK(std::ranges::find(seen.record->notes, "from the source") != seen.record->notes.end());
  CHECK(source.responses() == 1);
}

TEST_CASE("a response that no frame shows is not told to the source, which judges exposures by it") {
  test::MovingScene scene;
  scene.rows = 72, scene.cols = 96;
  scene.drift_px = 0.4, scene.disc_px = 0.8;
  scene.covered_frames = 14;
  const auto says_so = [] {
    REQUIRE(seen.record);
    return std::ranges::count(seen.record->notes,
                              "response: no frames tell it; the mean of real cameras stands in") == 1;
  };
  MemorySource covered(14, {}, scene);
  require_done(run(plan(), covered, posix_storage()));
  CHECK(covered.responses() == 0);
  CHECK(says_so());
  MemorySource uncovered(66, {}, scene);
  require_done(run(plan(), uncovered, posix_storage()));
  CHECK(uncovered.responses() >= 1);  // when it was learned
  CHECK_FALSE(says_so());
}

TEST_CASE("a run says so where no frame tells its noise") {
  test::MovingScene scene;
  scene.rows = 72, scene.cols = 96;
  scene.covered_frames = 14;
  MemorySource source(14, {}, scene);
  require_done(run(plan(), source, posix_storage()));
  REQUIRE(seen.record);
  CHECK(std::ranges::count(
            seen.record->notes,
            "noise (assumed, not measured): full well 4000 electrons, read noise 9.0 electrons") == 1);
}

TEST_CASE("a run says so where the first frame states no pose and later ones do") {
  const std::size_t first = GENERATE(0, 1, 99);
  MemorySource source(9, {});
  source.state_poses(first);
  RunPlan asked = plan();
  asked.settings.fit.emit = EmitLayer::Merged;
  require_done(run(asked, source, posix_storage()));
  REQUIRE(seen.record);
  const auto says_so = [](const std::string& note) {
    return note.starts_with("poses: the first frame states none");
  };
  CHECK(std::ranges::count_if(seen.record->notes, says_so) == (first == 1 ? 1 : 0));
}

TEST_CASE("without a deadline every frame is as asked, with one that is ample as well, if a little later") {
  MemorySource source(40, {});
  require_done(run(plan(), source, posix_storage()));
  CHECK(seen.record->deadline_ms == 0);
  CHECK(seen.record->rungs.empty());

  MemorySource again(100, {});
  RunPlan ample = plan();
  ample.settings.fit.deadline = "60s";
  require_done(run(ample, again, posix_storage()));
  CHECK(seen.record->deadline_ms == Approx(60e3));
  CHECK(seen.record->late == 0);
  CHECK(seen.sequences.size() == 100);
  REQUIRE(seen.record->rungs.size() > 2);
  CHECK(seen.record->rungs.front().name == "as asked");
  CHECK(seen.record->rungs.front().frames > 50);
  CHECK(seen.record->frames.back().rung == 0);
}

TEST_CASE("a deadline that nothing can hold leaves out frames, each of them counted, and none is lost") {
  MemorySource source(60, {});
  RunPlan short_of_time = plan();
  short_of_time.settings.fit.deadline = "1us";
  require_done(run(short_of_time, source, posix_storage()));
  const RunRecord& record = *seen.record;
  CHECK(record.late > 40);
  CHECK(record.left_out >= 2 + 5);  // of eight at three in 4, and of ten at one in 2 before that is given up
  CHECK(record.left_out == source.left_out_frames());
  CHECK(record.captured == 60);
  CHECK(record.emitted + record.left_out == 60);
  CHECK(record.dropped == record.left_out);
  CHECK(seen.sequences.size() == static_cast<std::size_t>(record.emitted));
  CHECK(record.rungs.back().name == "1 frame in 2");
  CHECK(record.rungs.back().frames >= 8);
  int all = 0;
  for (const RungRecord& rung : record.rungs) all += rung.frames;
  CHECK(all == 60);  // the last ones, too, which come when the source has ended
}

TEST_CASE(
    "rows that would be read out for longer than a frame are refused with the bound, before any frame") {
  MemorySource source(9, {});
  RunPlan with = plan();
  with.settings.fit.readout = "40ms";
  const Result<void> refused = run(with, source, posix_storage());
  require_error(refused, ErrorCode::Invalid);
  CHECK(
      refused.error().message ==
      "--readout 40ms is longer than a frame, 33.33 ms at 30 frames per second, and rows are read out within "
      "one; give at most 33.33 ms, or leave it out");
  CHECK(seen.sequences.empty());
  CHECK_FALSE(seen.record);
  for (const char* possible : {"33.33ms", "1/30", "12ms", "off", ""}) {
    INFO(possible);
    MemorySource another(9, {});
    with.settings.fit.readout = possible;
    require_done(run(with, another, posix_storage()));
  }
}

TEST_CASE("pictures that import turned have no rows to correct, and asking for it is refused") {
  CameraFacts camera;
  camera.name = "walk", camera.turned_upright = true;
  Settings::Fit fit;
  fit.readout = "12ms";
  const Result<void> refused = check_readout(fit, camera);
  require_error(refused, ErrorCode::Invalid);
  CHECK(refused.error().message ==
        "--readout is of rows that are read out from top to bottom, and the pictures of 'walk' were turned "
        "when they were imported; leave it out");
  camera.framerate_hz = 0;  // not known
  require_error(check_readout(fit, camera), ErrorCode::Invalid);
  for (const char* none : {"", "off"}) {
    fit.readout = none;
    require_done(check_readout(fit, camera));
  }
  camera.turned_upright = false;
  fit.readout = "12ms";
  require_done(check_readout(fit, camera));
}

TEST_CASE("a source that ends early is the reason, and what came before is emitted and concluded") {
  for (const int frames : {9, 1}) {
    MemorySource source(frames, Error{ErrorCode::Truncated, "cut"});
    require_error(run(plan(), source, posix_storage()), ErrorCode::Truncated);
    CHECK(seen.sequences.size() == (frames == 9 ? 9 : 0));
    CHECK(seen.record);
  }
}

TEST_CASE(
    "what fails behind the end of the source is the reason where nothing failed before, as ^C does not") {
  const Error cut{ErrorCode::Truncated, "cut"}, stopped{ErrorCode::Interrupted, "stopped"};
  for (const auto& [end, reason] : std::vector<std::pair<Result<void>, ErrorCode>>{
           {{}, ErrorCode::NoSpace}, {cut, ErrorCode::Truncated}, {stopped, ErrorCode::NoSpace}}) {
    MemorySource source(9, end);
    const RunPlan unconcluded = plan();
    SeeingSink::conclusion = Error{ErrorCode::NoSpace, "no room for the figures"};
    require_error(run(unconcluded, source, posix_storage()), reason);
  }
}

TEST_CASE("a clip of one frame is too short, whatever the sinks") {
  MemorySource source(1, {});
  require_error(run(plan(), source, posix_storage()), ErrorCode::TooShort);
}

TEST_CASE("a clip of any length has as many records of frames as a camera, unless something reads them") {
  RunPlan only_frames = plan();
  CHECK(frames_kept(only_frames, RunPace::Clip) == kFramesKept);
  RunRecord record;
  FrameRecord frame;
  for (; frame.sequence < 5000; ++frame.sequence)
    keep(frame, frames_kept(only_frames, RunPace::Clip), record);
  close_record(frames_kept(only_frames, RunPace::Clip), 1, record);
  CHECK(record.emitted == 5000);
  REQUIRE(record.frames.size() == kFramesKept);
  CHECK(record.frames.front().sequence == 5000 - kFramesKept);
  CHECK(record.frames.back().sequence == 4999);

  for (const char* reader : {"stats", "report"}) {
    RunPlan read = plan();
    read.settings.output.paths[reader] = "there";
    CHECK(frames_kept(read, RunPace::Clip) > 1'000'000'000);
    CHECK(frames_kept(read, RunPace::Camera) == kFramesKept);
  }
  RunPlan to_caller = plan();
  to_caller.record = &record;
  CHECK(frames_kept(to_caller, RunPace::Clip) > 1'000'000'000);
}

TEST_CASE("what is thrown amid a run is thrown at its end, once the sinks are finished") {
  const SinkKind kinds[] = {kKinds[0],
                            {"light", "--light", "what memory does not suffice for", SinkPace::Light,
                             SinkTarget::Files, [](const SinkRequest&) -> Result<std::unique_ptr<FrameSink>> {
                               return std::unique_ptr<FrameSink>(std::make_unique<LightSinkWithoutMemory>());
                             }}};
  RunPlan without_memory = plan();
  without_memory.sinks = kinds;
  without_memory.settings.output.paths["light"] = "nowhere";
  MemorySource source(9, {});
  CHECK_THROWS_AS(run(without_memory, source, posix_storage()), std::bad_alloc);
  CHECK(seen.sequences.size() == 1);
  CHECK(seen.finished);
}

TEST_CASE("a sink that fails ends the run with its own sentence") {
  MemorySource source(30, {});
  const RunPlan failing_plan = plan();
  SeeingSink::failing = true;
  const Result<void> ended = run(failing_plan, source, posix_storage());
  require_error(ended, ErrorCode::NoSpace);
  CHECK(ended.error().message == "the disk is full");
}

}  // namespace
}  // namespace hdrcam
