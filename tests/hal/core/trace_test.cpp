#include "hal/core/trace.h"

#include <nlohmann/json.hpp>
#include <thread>

#include "hal/core/thread_name.h"
#include "tests/support/trace_reading.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using std::chrono::microseconds;

TEST_CASE("a trace holds what each thread did, under the thread's name") {
  Trace trace;
  std::thread worker([&] {
    name_this_thread("a worker");
    const TraceSpan outer(&trace, "outer", 7);
    const TraceSpan inner(&trace, "inner \"quoted\"");
  });
  worker.join();
  std::thread([&] {
    name_this_thread("another thread with a long name");
    const TraceSpan span(&trace, "alone");
  }).join();
  const test::ReadTrace read(trace.json());
  CHECK(read.threads() == std::set<std::string>{"a worker", "another thread "});
  CHECK(read.names_on("a worker") == std::set<std::string>{"outer", "inner \"quoted\""});
  CHECK(read.names_on("another thread ") == std::set<std::string>{"alone"});
  CHECK(read.crossings().empty());
}

TEST_CASE("a trace holds the spans of any number of threads, as of one recorder for each take") {
  constexpr int kThreads = 200;
  Trace trace;
  for (int i = 0; i < kThreads; ++i)
    std::thread([&] {
      name_this_thread("recorder " + std::to_string(i));
      const TraceSpan span(&trace, "record", i);
    }).join();
  const test::ReadTrace read(trace.json());
  CHECK(read.threads().size() == kThreads);
  for (int i = 0; i < kThreads; ++i)
    CHECK(read.names_on("recorder " + std::to_string(i)) == std::set<std::string>{"record"});
}

TEST_CASE("a stage of which only the duration is known does not reach into the span before it") {
  Trace trace;
  {
    const TraceSpan frame(&trace, "frame");
    std::this_thread::sleep_for(microseconds(500));
    trace.add_stage("first", 0.1);
    trace.add_stage("second", 1e6);  // its clock was read earlier than ours
    trace.add_stage("third", 0.0);
  }
  const test::ReadTrace read(trace.json());
  CHECK(read.crossings().empty());
  const auto& second = read.span("second");
  const auto& first = read.span("first");
  CHECK(second.begin_us >= first.end_us - 0.002);  // times are whole nanoseconds
  CHECK(read.span("frame").end_us >= second.end_us);
}

TEST_CASE("spans that cross are found") {
  Trace trace;
  const auto begin = Trace::Clock::now();
  trace.add("one", begin, begin + microseconds(10));
  trace.add("other", begin + microseconds(5), begin + microseconds(15));
  CHECK(test::ReadTrace(trace.json()).crossings().size() == 1);
}

TEST_CASE("a full trace counts what it leaves out, and stays as it was") {
  Trace trace(3);
  for (int i = 0; i < 10; ++i) const TraceSpan span(&trace, "span");
  CHECK(trace.left_out() == 7);
  const auto json = nlohmann::json::parse(trace.json());
  CHECK(json["otherData"]["left_out"] == 7);
}
