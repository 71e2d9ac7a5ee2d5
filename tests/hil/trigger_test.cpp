// The trigger line on the kernel's simulated GPIO chip, seen from its other end: each pulse, its width, what
// is left of it when the program ends.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "capture/trigger_ledger.h"
#include "capture/trigger_thread.h"
#include "hal/real/enumerate.h"
#include "hal/real/sync_line_gpiod.h"
#include "hal/real/trigger_line_gpiod.h"
#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"
#include "tests/hil/program.h"

namespace hdrcam::hil {
namespace {

using namespace std::chrono_literals;

constexpr int kTriggerPin = 0, kStrobePin = 1;  // FSYNC, STROBE

// The trigger line with a sensor that answers at once: after each call that drives it, its level, read from
// the other end, goes to the strobe line. The kernel's stamps of that line tell when the level changed,
// whatever the scheduler does in between.
class EchoedLine : public TriggerLine {
 public:
  explicit EchoedLine(std::unique_ptr<TriggerLine> inner) : inner_(std::move(inner)) { echo(); }

  const std::string& name() const override { return inner_->name(); }
  Result<DrivenEdge> drive(LineLevel level) override {
    const auto edge = inner_->drive(level);
    echo();
    return edge;
  }

 private:
  void echo() { strobe_.drive(trigger_.level()); }

  std::unique_ptr<TriggerLine> inner_;
  const SimulatedPin trigger_{kTriggerPin}, strobe_{kStrobePin};
};

TEST_CASE("every trigger pulse is seen on the GPIO line, as wide as it should be") {
  constexpr Exposure kCycle[] = {{10ms, 1}, {20ms, 1}, {40ms, 1}};
  constexpr std::size_t kPulses = 90;
  constexpr Duration kTolerance = 2ms;  // of three widths in four: the emulated processor is stopped at will
  auto line = std::make_unique<EchoedLine>(value_of(open_trigger_gpio({.line = "FSYNC"})));
  const auto strobe = value_of(open_gpio_line({.line = "STROBE"}));
  const TriggerOptions options{.mode = TriggerMode::PulseWidth, .interval = 100ms, .tolerance = 2ms};
  Trigger trigger(std::move(line), options, posix_clock());
  const TriggerThread thread(trigger);
  CHECK(thread.realtime().ok());  // root may
  TriggerLedger ledger;
  ledger.start(options);
  require_done(trigger.start(value_of(ExposureSchedule::observed(kCycle))));
  std::vector<TriggerPulse> pulses;
  std::vector<Edge> edges;
  const auto take = [&](Duration patience) {
    while (const auto pulse = trigger.take()) pulses.push_back(*pulse), ledger.pulse(*pulse);
    const auto edge = strobe->wait_edge(patience);
    if (edge) edges.push_back(edge.value()), ledger.answer(edge.value());
    return edge.ok();
  };
  while (pulses.size() < kPulses) take(20ms);
  trigger.stop();
  while (take(200ms)) {
  }
  ledger.settle(posix_clock().now());

  CHECK(pulses.size() == trigger.driven());
  REQUIRE(edges.size() == 2 * pulses.size());
  std::vector<Duration> off;
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    REQUIRE(edges[2 * i].rising);
    REQUIRE_FALSE(edges[2 * i + 1].rising);
    off.push_back(std::chrono::abs(edges[2 * i + 1].at - edges[2 * i].at - pulses[i].width()));
  }
  std::sort(off.begin(), off.end());
  const TriggerCounters& counters = ledger.counters();
  fmt::print("{}; widths seen are {:.2f} ms off in the median, {:.2f} for three in four, {:.2f} at most\n",
             sentence_of(counters, "FSYNC", options, TriggerAnswers::Heard),
             to_seconds(off[off.size() / 2]) * 1e3, to_seconds(off[off.size() * 3 / 4]) * 1e3,
             to_seconds(off.back()) * 1e3);
  CHECK(off[off.size() * 3 / 4] <= kTolerance);
  CHECK(counters.unanswered + counters.spurious == 0);
  CHECK_FALSE(SimulatedPin(kTriggerPin).level());
}

// Pulses of 60 ms, 100 ms apart, beside a camera that runs freely.
std::vector<std::string> recording_with_trigger(const std::string& camera, const std::string& line) {
  return {"record",
          "--camera",
          camera,
          "--format",
          "YUYV",
          "--width",
          "160",
          "--height",
          "120",
          "--framerate",
          "10",
          "--control-delay",
          "1",
          "--trigger-line",
          line,
          "--trigger",
          "fsync",
          "--trigger-width",
          "60ms",
          "-o",
          "/tmp/triggered.mkv",
          "--force"};
}

bool becomes(const SimulatedPin& pin, bool level, std::chrono::milliseconds within) {
  const auto end = std::chrono::steady_clock::now() + within;
  while (pin.level() != level && std::chrono::steady_clock::now() < end) {
  }
  return pin.level() == level;
}

TEST_CASE("hdrcam names the holder of a trigger line that another has, and lines that are the same") {
  constexpr int kHeld = 13, kInvalid = 2;
  const UsbCamera plugged(1, 10);
  Program held(recording_with_trigger(plugged.node(), "HELD"));
  CHECK(held.exit_code() == kHeld);
  CHECK_THAT(Program::words(), Catch::Contains("'HELD' is held by 'pwm-fan'"));
  auto twice = recording_with_trigger(plugged.node(), "gpiochip0:0");
  for (const char* word : {"--sync-line", "FSYNC"}) twice.emplace_back(word);
  Program same(twice);
  CHECK(same.exit_code() == kInvalid);
  CHECK_THAT(Program::words(), Catch::Contains("'gpiochip0:0' and --sync-line 'FSYNC' are the same line"));
}

TEST_CASE("hdrcam leaves the trigger line inactive, and free, when it ends and when it is told to") {
  const UsbCamera plugged(1, 10);
  const SimulatedPin pin(kTriggerPin);
  auto ends = recording_with_trigger(plugged.node(), "FSYNC");
  for (const char* word : {"--frames", "20"}) ends.emplace_back(word);
  Program record(ends);
  CHECK(becomes(pin, true, 30s));
  const int code = record.exit_code();
  INFO(Program::words());
  CHECK(code == 0);
  CHECK_FALSE(pin.level());
  CHECK_THAT(Program::words(), Catch::Contains("trigger 'FSYNC' (frame start):"));
  fmt::print("{}", Program::words());

  Program stopped(recording_with_trigger(plugged.node(), "FSYNC"));
  REQUIRE(becomes(pin, true, 30s));
  stopped.signal(SIGTERM);
  CHECK(stopped.exit_code() >= 0);
  CHECK_FALSE(pin.level());
  CHECK(open_trigger_gpio({.line = "FSYNC"}).ok());
}

// gpio-sim lets a line that nobody holds follow its pull. With a pull-up only somebody who drives it is low.
TEST_CASE("when hdrcam is killed in the middle of a pulse, its guard drives the trigger line inactive") {
  const UsbCamera plugged(1, 10);
  const SimulatedPin pin(kTriggerPin);
  Program killed(recording_with_trigger(plugged.node(), "FSYNC"));
  REQUIRE(becomes(pin, true, 30s));
  REQUIRE(becomes(pin, false, 5s));
  pin.drive(true);
  REQUIRE(becomes(pin, true, 5s));
  killed.signal(SIGKILL);
  const auto begin = std::chrono::steady_clock::now();
  CHECK(killed.exit_code() == -1);
  const bool fell = becomes(pin, false, 5s);
  const Duration after = std::chrono::steady_clock::now() - begin;
  CHECK(fell);
  CHECK(value_of(inspect_gpio_chip("/dev/gpiochip0")).lines[kTriggerPin].consumer == "hdrcam");
  fmt::print("killed: the guard drove the line inactive {:.1f} ms later\n", to_seconds(after) * 1e3);
  pin.drive(false);
  for (int i = 0; i < 1000 && !open_trigger_gpio({.line = "FSYNC"}).ok(); ++i)
    std::this_thread::sleep_for(10ms);
  CHECK(open_trigger_gpio({.line = "FSYNC"}).ok());
  CHECK_FALSE(pin.level());
}

}  // namespace
}  // namespace hdrcam::hil
