#include "firmware_host/sinks/async_sink.h"

#include <atomic>
#include <future>
#include <new>

#include "tests/allocation_checks.h"
#include "tests/firmware_host/sinks/example_frames.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::emit;
using test::example_frame;

namespace {

// What a sink saw: sequence numbers of the HDR frame and of the input, brightest radiance, and whether it was
// finished. The tests judge it: Catch2's assertions belong to one thread.
struct Seen {
  std::vector<std::uint64_t> sequences, inputs;
  std::vector<float> brightest;
  bool finished = false;
};

// Takes each frame when the gate opens; fails at one of them.
class GatedSink : public FrameSink {
 public:
  GatedSink(Seen& seen, std::shared_future<void> gate, std::uint64_t fails_at = ~0ull)
      : seen_(seen), gate_(std::move(gate)), fails_at_(fails_at) {}

  Result<void> emit(const EmittedFrame& frame) override {
    gate_.wait();
    if (frame.record.sequence == fails_at_) return Error{ErrorCode::NoSpace, "the disk is full"};
    seen_.inputs.push_back(frame.input.facts.sequence);
    seen_.sequences.push_back(frame.hdr.facts.sequence);
    seen_.brightest.push_back(frame.hdr.radiance.at(0, 0, 31));
    return {};
  }
  Result<void> finish() override { return seen_.finished = true, Result<void>{}; }

 private:
  Seen& seen_;
  std::shared_future<void> gate_;
  const std::uint64_t fails_at_;
};

class SinkWithoutMemory : public FrameSink {
 public:
  Result<void> emit(const EmittedFrame&) override { throw std::bad_alloc(); }
};

struct Gate {
  std::promise<void> promise;
  std::shared_future<void> opened = promise.get_future().share();
};

}  // namespace

TEST_CASE("behind its queue a sink sees every frame in order, as it was when it was emitted") {
  Gate gate;
  gate.promise.set_value();
  Seen seen;
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened), WhenFull::Wait, ThreadPriority::Usual);
  HdrFrame frame = example_frame(0);  // one frame, overwritten each time, as the pipeline does
  std::vector<std::uint64_t> sequences;
  std::vector<float> brightest;
  for (std::uint64_t i = 0; i < 50; ++i) {
    sequences.push_back(frame.facts.sequence = i);
    brightest.push_back(frame.radiance.at(0, 0, 31) = static_cast<float>(i) + 0.5f);
    REQUIRE(emit(sink, frame).ok());
  }
  REQUIRE(sink.finish().ok());
  CHECK(seen.finished);
  CHECK(seen.sequences == sequences);
  CHECK(seen.inputs == sequences);
  CHECK(seen.brightest == brightest);
  CHECK(sink.times().frames == 50);
  CHECK(sink.times().left_out == 0);
}

TEST_CASE("a full queue holds the emitting thread up until there is room") {
  Gate gate;
  Seen seen;
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened), WhenFull::Wait, ThreadPriority::Usual);
  constexpr std::uint64_t kFrames = AsyncSink::kDepth + 5;
  std::atomic<std::uint64_t> emitted{0};
  std::future<void> emitting = std::async(std::launch::async, [&] {
    for (std::uint64_t i = 0; i < kFrames; ++i, ++emitted) (void)emit(sink, example_frame(i));
  });
  while (emitted < AsyncSink::kDepth + 1) std::this_thread::yield();
  CHECK(emitting.wait_for(std::chrono::milliseconds(50)) == std::future_status::timeout);
  CHECK(emitted == AsyncSink::kDepth + 1);
  gate.promise.set_value();
  emitting.get();
  REQUIRE(sink.finish().ok());
  CHECK(seen.sequences.size() == kFrames);
}

TEST_CASE("a sink that may leave out frames holds nobody up and counts what it left out") {
  Gate gate;
  Seen seen;
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened), WhenFull::DropFrame, ThreadPriority::Usual);
  for (std::uint64_t i = 0; i < 10; ++i) REQUIRE(emit(sink, example_frame(i)).ok());
  gate.promise.set_value();
  REQUIRE(sink.finish().ok());
  CHECK(seen.sequences == std::vector<std::uint64_t>{0, 1, 2});
  CHECK(sink.times().frames == 3);
  CHECK(sink.times().left_out == 7);
}

TEST_CASE("a queue holds fewer frames where they are large, but at least one") {
  CHECK(AsyncSink::slots_for(1) == AsyncSink::kDepth + 1);
  CHECK(AsyncSink::slots_for(AsyncSink::kMostBytes / (AsyncSink::kDepth + 1)) == AsyncSink::kDepth + 1);
  CHECK(AsyncSink::slots_for(AsyncSink::kMostBytes / 2) == 2);
  CHECK(AsyncSink::slots_for(10 * AsyncSink::kMostBytes) == 1);

  Gate gate;
  Seen seen;
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened), WhenFull::DropFrame, ThreadPriority::Usual);
  HdrFrame large = example_frame(0, test::With::RadianceOnly, 1600, 1600);  // 43 MB
  for (; large.facts.sequence < 4; ++large.facts.sequence) REQUIRE(emit(sink, large).ok());
  gate.promise.set_value();
  REQUIRE(sink.finish().ok());
  CHECK(seen.sequences == std::vector<std::uint64_t>{0});
  CHECK(sink.times().left_out == 3);
}

TEST_CASE("a queue copies the codes of the input only for a sink that looks at them") {
  class InputSink : public FrameSink {
   public:
    InputSink(InputUse use, std::size_t& codes) : use_(use), codes_(codes) {}
    InputUse input_use() const override { return use_; }
    Result<void> emit(const EmittedFrame& frame) override {
      return codes_ = frame.input.codes.size(), Result<void>{};
    }

   private:
    const InputUse use_;
    std::size_t& codes_;
  };
  for (const InputUse use : {InputUse::Facts, InputUse::Codes}) {
    std::size_t codes = 1;
    AsyncSink sink(std::make_unique<InputSink>(use, codes), WhenFull::Wait, ThreadPriority::Usual);
    CHECK(sink.input_use() == use);
    REQUIRE(emit(sink, example_frame(0), Image<float>(3, 24, 32)).ok());
    REQUIRE(sink.finish().ok());
    CHECK(codes == (use == InputUse::Codes ? 3 * 24 * 32 : 0));
  }
}

TEST_CASE("the error of a sink reaches the emitting thread, also one that waits, and finish") {
  Gate gate;
  gate.promise.set_value();
  Seen seen;
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened, 3), WhenFull::Wait, ThreadPriority::Usual);
  Result<void> last;
  std::uint64_t i = 0;
  for (; last && i < 100; ++i) last = emit(sink, example_frame(i));
  REQUIRE_FALSE(last.ok());
  CHECK(last.error().message == "the disk is full");
  CHECK(i <= 3 + AsyncSink::kDepth + 3);
  CHECK(sink.finish().error().code == ErrorCode::NoSpace);
  CHECK(seen.sequences == std::vector<std::uint64_t>{0, 1, 2});
  CHECK_FALSE(seen.finished);
}

TEST_CASE("what a sink throws reaches the emitting thread and finish, as an error does") {
  AsyncSink sink(std::make_unique<SinkWithoutMemory>(), WhenFull::Wait, ThreadPriority::Usual);
  const auto emit_many = [&] {
    for (std::uint64_t i = 0; i < 100; ++i) (void)emit(sink, example_frame(i));
  };
  CHECK_THROWS_AS(emit_many(), std::bad_alloc);
  CHECK_THROWS_AS(sink.finish(), std::bad_alloc);
}

TEST_CASE("a queue allocates nothing once each of its frames was used") {
  Gate gate;
  gate.promise.set_value();
  Seen seen;
  seen.sequences.reserve(100), seen.inputs.reserve(100), seen.brightest.reserve(100);
  AsyncSink sink(std::make_unique<GatedSink>(seen, gate.opened), WhenFull::Wait, ThreadPriority::Usual);
  const HdrFrame frame = example_frame(0, test::With::DepthAndFlow);
  ExposedFrame input;
  input.codes = Image<float>(3, 24, 32);
  const FrameRecord record;
  for (int i = 0; i < 10; ++i) REQUIRE(sink.emit({frame, input, record}).ok());
  bool emitted = true;  // an assertion may allocate
  const std::uint64_t before = own_allocations_so_far();
  for (int i = 0; i < 50; ++i) emitted = sink.emit({frame, input, record}).ok() && emitted;
  emitted = sink.finish().ok() && emitted;  // until the sink's thread has done all of them, too
  const std::uint64_t taken = own_allocations_so_far() - before;
  CHECK(emitted);
  CHECK_ALLOCATIONS(taken == 0);
}
