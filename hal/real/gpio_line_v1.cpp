// libgpiod 1.x (Debian 12 has 1.6.3).
#ifdef HDRCAM_HAVE_GPIOD
#include <gpiod.h>
#ifdef GPIOD_LINE_BULK_MAX_LINES  // gone in version 2

#include <cerrno>

#include "hal/real/gpio_line.h"

namespace hdrcam {
namespace {

constexpr const char* kConsumer = "hdrcam";

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

class LineV1 : public GpioLine {
 public:
  LineV1(Chip chip, gpiod_line* line, std::string name)
      : chip_(std::move(chip)), line_(line), name_(std::move(name)) {}
  ~LineV1() override { gpiod_line_release(line_); }

  Result<void> set(LineLevel level) override {
    if (gpiod_line_set_value(line_, level == LineLevel::Active ? 1 : 0) != 0)
      return line_error(errno, name_, "");
    return {};
  }
  int event_fd() const override { return gpiod_line_event_get_fd(line_); }
  Result<GpioEvent> read_event() override {
    gpiod_line_event event{};
    if (gpiod_line_event_read(line_, &event) != 0) return line_error(errno, name_, "");
    return GpioEvent{event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
                     std::chrono::seconds(event.ts.tv_sec) + std::chrono::nanoseconds(event.ts.tv_nsec),
                     std::nullopt};
  }

 private:
  Chip chip_;
  gpiod_line* line_;  // the chip's
  std::string name_;
};

struct FoundLine {
  Chip chip;
  gpiod_line* line = nullptr;
};

Result<FoundLine> find_line(const std::string& name) {
  int refused = ENOENT;
  if (const auto parsed = parse_line_name(name)) {
    FoundLine found{Chip(gpiod_chip_open(("/dev/" + parsed->chip).c_str()))};
    if (!found.chip) return line_error(errno, name, "");
    if (parsed->offset >= gpiod_chip_num_lines(found.chip.get())) return line_error(ENOENT, name, "");
    found.line = gpiod_chip_get_line(found.chip.get(), parsed->offset);
    if (found.line == nullptr) return line_error(errno, name, "");
    return found;
  }
  for (const std::string& node : gpio_chip_nodes()) {
    FoundLine found{Chip(gpiod_chip_open(node.c_str()))};
    if (!found.chip) {
      refused = errno;
      continue;
    }
    found.line = gpiod_chip_find_line(found.chip.get(), name.c_str());
    if (found.line != nullptr) return found;
  }
  return line_error(refused, name, "");
}

}  // namespace

Result<std::unique_ptr<GpioLine>> request_gpio_line(const GpioSettings& settings, LineDirection direction) {
  const std::string& name = settings.line;
  auto found = TRY(find_line(name));
  const int flags = settings.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  const int code = direction == LineDirection::Output
                       ? gpiod_line_request_output_flags(found.line, kConsumer, flags, 0)
                       : gpiod_line_request_both_edges_events_flags(found.line, kConsumer, flags);
  if (code != 0) {
    const int reason = errno;
    const char* consumer = gpiod_line_consumer(found.line);
    return line_error(reason, name, consumer == nullptr ? "" : consumer);
  }
  return std::unique_ptr<GpioLine>(std::make_unique<LineV1>(std::move(found.chip), found.line, name));
}

Result<GpioChipState> inspect_gpio_chip(const std::string& node) {
  const Chip chip(gpiod_chip_open(node.c_str()));
  if (!chip) return line_error(errno, node, "");
  const auto state_of = [&](unsigned offset) -> std::optional<GpioLineState> {
    gpiod_line* line = gpiod_chip_get_line(chip.get(), offset);
    if (line == nullptr) return std::nullopt;
    const auto text = [](const char* maybe) { return std::string(maybe == nullptr ? "" : maybe); };
    return GpioLineState{
        text(gpiod_line_name(line)), gpiod_line_is_used(line) ? GpioLineUse::Held : GpioLineUse::Free,
        text(gpiod_line_consumer(line)), gpiod_line_direction(line) == GPIOD_LINE_DIRECTION_OUTPUT};
  };
  return GpioChipState{gpiod_chip_name(chip.get()), gpiod_chip_label(chip.get()),
                       lines_by_number(gpiod_chip_num_lines(chip.get()), state_of)};
}

}  // namespace hdrcam
#endif
#endif
