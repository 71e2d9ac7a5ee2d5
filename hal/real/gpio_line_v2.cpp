// libgpiod 2.x.
#ifdef HDRCAM_HAVE_GPIOD
#include <gpiod.h>
#ifndef GPIOD_LINE_BULK_MAX_LINES

#include <cerrno>

#include "hal/real/gpio_line.h"
#include "hal/sync_line.h"

namespace hdrcam {
namespace {

constexpr const char* kConsumer = "hdrcam";

template <auto free_it>
struct Free {
  void operator()(auto* it) const { free_it(it); }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using Settings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using LineRequest = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using EventBuffer = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

class LineV2 : public GpioLine {
 public:
  LineV2(LineRequest request, unsigned offset, std::string name)
      : request_(std::move(request)),
        events_(gpiod_edge_event_buffer_new(1)),
        offset_(offset),
        name_(std::move(name)) {}

  Result<void> set(LineLevel level) override {
    const auto value = level == LineLevel::Active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(request_.get(), offset_, value) != 0)
      return line_error(errno, name_, "");
    return {};
  }
  int event_fd() const override { return gpiod_line_request_get_fd(request_.get()); }
  Result<GpioEvent> read_event() override {
    if (gpiod_line_request_read_edge_events(request_.get(), events_.get(), 1) != 1)
      return line_error(errno, name_, "");
    gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(events_.get(), 0);
    return GpioEvent{gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
                     Duration(gpiod_edge_event_get_timestamp_ns(event)),
                     gpiod_edge_event_get_line_seqno(event)};
  }

 private:
  LineRequest request_;
  EventBuffer events_;
  unsigned offset_;
  std::string name_;
};

struct FoundLine {
  Chip chip;
  unsigned offset = 0;
};

Result<FoundLine> find_line(const std::string& name) {
  int refused = ENOENT;
  if (const auto parsed = parse_line_name(name)) {
    FoundLine found{Chip(gpiod_chip_open(("/dev/" + parsed->chip).c_str())), parsed->offset};
    if (!found.chip) return line_error(errno, name, "");
    return found;
  }
  for (const std::string& node : gpio_chip_nodes()) {
    FoundLine found{Chip(gpiod_chip_open(node.c_str()))};
    if (!found.chip) {
      refused = errno;
      continue;
    }
    const int offset = gpiod_chip_get_line_offset_from_name(found.chip.get(), name.c_str());
    if (offset < 0) continue;
    found.offset = static_cast<unsigned>(offset);
    return found;
  }
  return line_error(refused, name, "");
}

}  // namespace

Result<std::unique_ptr<GpioLine>> request_gpio_line(const GpioSettings& settings, LineDirection direction) {
  const std::string& name = settings.line;
  const auto found = TRY(find_line(name));
  const LineInfo info(gpiod_chip_get_line_info(found.chip.get(), found.offset));
  if (!info) return line_error(ENOENT, name, "");
  const Settings line_settings(gpiod_line_settings_new());
  const LineConfig lines(gpiod_line_config_new());
  const RequestConfig request(gpiod_request_config_new());
  if (!line_settings || !lines || !request) return line_error(ENOMEM, name, "");
  gpiod_request_config_set_consumer(request.get(), kConsumer);
  gpiod_line_settings_set_active_low(line_settings.get(), settings.active_low);
  if (direction == LineDirection::Output) {
    gpiod_line_settings_set_direction(line_settings.get(), GPIOD_LINE_DIRECTION_OUTPUT);
    gpiod_line_settings_set_output_value(line_settings.get(), GPIOD_LINE_VALUE_INACTIVE);
  } else {
    gpiod_line_settings_set_direction(line_settings.get(), GPIOD_LINE_DIRECTION_INPUT);
    gpiod_line_settings_set_edge_detection(line_settings.get(), GPIOD_LINE_EDGE_BOTH);
    gpiod_line_settings_set_event_clock(line_settings.get(), GPIOD_LINE_CLOCK_MONOTONIC);
    // the kernel keeps 16 unless it is asked for more, and then loses the oldest
    gpiod_request_config_set_event_buffer_size(request.get(), SyncLine::kMostWaiting);
  }
  gpiod_line_config_add_line_settings(lines.get(), &found.offset, 1, line_settings.get());
  LineRequest granted(gpiod_chip_request_lines(found.chip.get(), request.get(), lines.get()));
  if (!granted) {
    const int reason = errno;
    const char* consumer = gpiod_line_info_get_consumer(info.get());
    return line_error(reason, name, consumer == nullptr ? "" : consumer);
  }
  return std::unique_ptr<GpioLine>(std::make_unique<LineV2>(std::move(granted), found.offset, name));
}

Result<GpioChipState> inspect_gpio_chip(const std::string& node) {
  const Chip chip(gpiod_chip_open(node.c_str()));
  if (!chip) return line_error(errno, node, "");
  const ChipInfo info(gpiod_chip_get_info(chip.get()));
  if (!info) return line_error(errno, node, "");
  const auto state_of = [&](unsigned offset) -> std::optional<GpioLineState> {
    const LineInfo line(gpiod_chip_get_line_info(chip.get(), offset));
    if (!line) return std::nullopt;
    const auto text = [](const char* maybe) { return std::string(maybe == nullptr ? "" : maybe); };
    return GpioLineState{text(gpiod_line_info_get_name(line.get())),
                         gpiod_line_info_is_used(line.get()) ? GpioLineUse::Held : GpioLineUse::Free,
                         text(gpiod_line_info_get_consumer(line.get())),
                         gpiod_line_info_get_direction(line.get()) == GPIOD_LINE_DIRECTION_OUTPUT};
  };
  return GpioChipState{
      gpiod_chip_info_get_name(info.get()), gpiod_chip_info_get_label(info.get()),
      lines_by_number(static_cast<unsigned>(gpiod_chip_info_get_num_lines(info.get())), state_of)};
}

}  // namespace hdrcam
#endif
#endif
