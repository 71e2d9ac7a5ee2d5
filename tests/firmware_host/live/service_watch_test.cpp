#include "firmware_host/live/service_watch.h"

#include <atomic>
#include <new>

#include "tests/support/becomes_true.h"
#include "tests/support/notify_socket.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

struct FitCounts {
  std::uint64_t taken = 0, emitted = 0, waiting = 0;
};
LiveCounters counted(std::uint64_t captured, FitCounts fit = {}, std::uint64_t recorded = 0,
                     std::uint64_t to_record = 0) {
  LiveCounters counters;
  counters.camera.captured = captured;
  counters.taken = fit.taken, counters.emitted = fit.emitted;
  counters.in_fit = fit.waiting + fit.taken - fit.emitted;
  counters.recorded = recorded, counters.to_record = to_record;
  return counters;
}

// Datagrams until one has the word.
std::string until(NotifySocket& socket, const std::string& word) {
  for (;;) {
    const std::string text = socket.next();
    if (text.empty() || text.find(word) != std::string::npos) return text;
  }
}

}  // namespace

TEST_CASE("a run is alive while capture, fit and recorder get on") {
  SignOfLife life;
  CHECK(life.seen(counted(1)));
  CHECK(life.seen(counted(2)));
  SECTION("a camera that delivers nothing is no sign of life") {
    CHECK_FALSE(life.seen(counted(2)));
    CHECK(life.seen(counted(3)));
  }
  SECTION("a fit that hangs is none, however many frames wait for it; one without frames is well") {
    CHECK(life.seen(counted(3, {.taken = 2, .emitted = 1, .waiting = 1})));
    CHECK_FALSE(life.seen(counted(4, {.taken = 2, .emitted = 1, .waiting = 2})));
    CHECK_FALSE(life.seen(counted(90, {.taken = 2, .emitted = 1, .waiting = 30})));
    CHECK(life.seen(counted(91, {.taken = 3, .emitted = 2, .waiting = 29})));
    CHECK(life.seen(counted(92, {.taken = 32, .emitted = 31, .waiting = 0})));
  }
  SECTION("a fit may keep frames until later ones come, though all later ones are kept from it") {
    CHECK(life.seen(counted(3, {.taken = 3, .emitted = 2})));
    CHECK(life.seen(counted(900, {.taken = 3, .emitted = 2})));
  }
  SECTION("a disk that hangs is none") {
    CHECK(life.seen(counted(3, {}, 1, 2)));
    CHECK_FALSE(life.seen(counted(4, {}, 1, 3)));
    CHECK(life.seen(counted(5, {}, 2, 3)));
  }
}

TEST_CASE("a service is ready with its first frame, gives signs of life, and says that it stops") {
  NotifySocket socket(NotifySocket::Where::Path);
  std::atomic<std::uint64_t> captured{0};
  ServiceWatch watch(
      Supervisor(socket.name(), milliseconds(100)), [&] { return counted(captured); },
      [](const LiveCounters& now) { return "captured " + std::to_string(now.captured()); });
  CHECK(socket.next() == "STATUS=captured 0\n");
  captured = 1;
  CHECK_THAT(until(socket, "READY=1"), Catch::StartsWith("READY=1\nWATCHDOG=1\n"));
  CHECK(socket.next(300).find("WATCHDOG") == std::string::npos);  // no frame since then
  captured = 2;
  CHECK_THAT(until(socket, "WATCHDOG=1"), Catch::StartsWith("WATCHDOG=1\n"));
  watch.stopping();
  CHECK_THAT(until(socket, "STOPPING"), Catch::Equals("STOPPING=1"));
  captured = 3;
  CHECK(socket.next(300).empty());
}

TEST_CASE("that a service is ready and that it stops reaches a service manager that was busy at the time") {
  NotifySocket socket(NotifySocket::Where::Path);
  const Supervisor others(socket.name(), {});
  const auto busy = [&] {
    while (others.tell("STATUS=of another service")) continue;
  };
  std::atomic<int> looks{0};
  std::atomic<bool> ended{false};
  busy();
  ServiceWatch watch(
      Supervisor(socket.name(), milliseconds(100)),
      [&] {
        LiveCounters now = counted(30);
        now.ended = ended;
        ++looks;
        return now;
      },
      [](const LiveCounters&) { return "runs"; });
  const auto look = [&] {
    const int before = looks;
    return test::becomes_true([&] { return looks >= before + 2; });
  };
  REQUIRE(look());  // what the first one says is lost
  CHECK_THAT(until(socket, "READY=1"), Catch::StartsWith("READY=1\n"));
  busy();
  ended = true;
  REQUIRE(look());
  CHECK_THAT(until(socket, "STOPPING"), Catch::Equals("STOPPING=1"));
}

TEST_CASE("a service whose line of status finds no memory is ready and alive all the same") {
  NotifySocket socket(NotifySocket::Where::Path);
  std::atomic<std::uint64_t> captured{0};
  ServiceWatch watch(
      Supervisor(socket.name(), milliseconds(100)), [&] { return counted(++captured); },
      [](const LiveCounters&) -> std::string { throw std::bad_alloc(); });
  CHECK_THAT(until(socket, "READY=1"), Catch::StartsWith("READY=1\nWATCHDOG=1\n"));
  CHECK_THAT(until(socket, "WATCHDOG=1"), Catch::StartsWith("WATCHDOG=1\n"));
}

TEST_CASE("a service whose camera has ended says once that it stops, though the fit still works") {
  NotifySocket socket(NotifySocket::Where::Path);
  std::atomic<bool> ended{false};
  ServiceWatch watch(
      Supervisor(socket.name(), milliseconds(100)),
      [&] {
        LiveCounters now = counted(30, {.taken = 2, .emitted = 1, .waiting = 28});
        now.ended = ended;
        return now;
      },
      [](const LiveCounters&) { return "some frames wait"; });
  CHECK_THAT(until(socket, "READY=1"), Catch::StartsWith("READY=1\nWATCHDOG=1\n"));
  CHECK(socket.next(300).empty());
  ended = true;
  CHECK_THAT(until(socket, "STOPPING"), Catch::Equals("STOPPING=1"));
  watch.stopping();
  for (std::string text = socket.next(300); !text.empty(); text = socket.next(300))
    CHECK(text.find("STOPPING") == std::string::npos);
}
