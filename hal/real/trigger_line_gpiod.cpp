#include "hal/real/trigger_line_gpiod.h"

#include <chrono>
#include <thread>
#include <utility>

#include "hal/clock.h"

namespace hdrcam {
namespace {

class GpioTriggerLine : public TriggerLine {
 public:
  GpioTriggerLine(std::unique_ptr<GpioLine> line, std::string name)
      : line_(std::move(line)), name_(std::move(name)) {}
  ~GpioTriggerLine() override { (void)line_->set(LineLevel::Inactive); }

  const std::string& name() const override { return name_; }
  Result<DrivenEdge> drive(LineLevel level) override {
    const Instant before = posix_clock().now();
    TRY(line_->set(level));
    const Duration half = (posix_clock().now() - before) / 2;
    return DrivenEdge{before + half, half};
  }

 private:
  std::unique_ptr<GpioLine> line_;
  std::string name_;
};

// The kernel takes the line from a dead process after it has closed that process's other files, so the first
// attempts may find it held.
void leave_inactive(const GpioSettings& settings) {
  constexpr int kAttempts = 5000;
  constexpr auto kPause = std::chrono::milliseconds(1);
  for (int i = 0; i < kAttempts; ++i) {
    const auto line = request_gpio_line(settings, LineDirection::Output);
    if (line) return std::this_thread::sleep_for(kHeldInactive);
    if (line.error().code != ErrorCode::Busy) return;
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace

Result<std::unique_ptr<TriggerLine>> open_trigger_gpio(const GpioSettings& settings) {
  auto line = TRY(request_gpio_line(settings, LineDirection::Output));
  return std::unique_ptr<TriggerLine>(std::make_unique<GpioTriggerLine>(std::move(line), settings.line));
}

Result<std::unique_ptr<LastAct>> guard_trigger_gpio(const GpioSettings& settings) {
  return LastAct::prepare("hdrcam-guard", [settings] { leave_inactive(settings); });
}

}  // namespace hdrcam
