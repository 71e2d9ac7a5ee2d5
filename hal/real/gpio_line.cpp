#include "hal/real/gpio_line.h"

#include <cerrno>
#include <cstring>

#include "hal/core/parse_number.h"
#include "hal/real/device_node.h"

namespace hdrcam {

std::optional<GpioLineName> parse_line_name(const std::string& name) {
  const auto colon = name.find(':');
  if (!name.starts_with("gpiochip") || colon == std::string::npos) return std::nullopt;
  const auto offset = parse_number<decltype(GpioLineName::offset)>(std::string_view(name).substr(colon + 1));
  if (!offset) return std::nullopt;
  return GpioLineName{name.substr(0, colon), *offset};
}

std::vector<GpioLineState> lines_by_number(
    unsigned count, const std::function<std::optional<GpioLineState>(unsigned)>& state_of) {
  std::vector<GpioLineState> lines;
  lines.reserve(count);
  for (unsigned i = 0; i < count; ++i)
    lines.push_back(state_of(i).value_or(GpioLineState{.use = GpioLineUse::Unreadable}));
  return lines;
}

std::string describe(const GpioLineState& line, const std::string& chip, std::size_t number) {
  if (line.name.empty() && line.use == GpioLineUse::Free) return "";
  std::string text = fmt::format("{}:{} {}", chip, number, line.name.empty() ? "unnamed" : line.name);
  if (line.output) text += ", output";
  if (line.use == GpioLineUse::Unreadable) text += ", its state cannot be read";
  if (line.use == GpioLineUse::Held)
    text += line.consumer.empty() ? ", held" : fmt::format(", held by '{}'", line.consumer);
  return text;
}

std::vector<std::string> gpio_chip_nodes() { return device_nodes("gpiochip"); }

namespace {

// "gpiochip0:17", of a line's own name and of "gpiochip0:017" too; any other text as it is.
std::string place_of(const std::string& name) {
  if (const auto place = parse_line_name(name)) return fmt::format("{}:{}", place->chip, place->offset);
  for (const std::string& node : gpio_chip_nodes()) {
    const auto chip = inspect_gpio_chip(node);
    for (std::size_t i = 0; chip && i < chip.value().lines.size(); ++i)
      if (chip.value().lines[i].name == name) return fmt::format("{}:{}", chip.value().name, i);
  }
  return name;
}

}  // namespace

bool same_gpio_line(const std::string& a, const std::string& b) { return place_of(a) == place_of(b); }

Error line_error(int code, const std::string& name, const std::string& consumer) {
  switch (code) {
    case EBUSY:
      return {ErrorCode::Busy,
              fmt::format("GPIO line '{}' is held by '{}'; free it or choose another line", name,
                          consumer.empty() ? "another program" : consumer),
              code};
    case ENOENT:
      return {ErrorCode::NotFound,
              fmt::format("there is no GPIO line '{}'; 'hdrcam list' shows those that there are", name),
              code};
    case EACCES:
    case EPERM: {
      const auto nodes = gpio_chip_nodes();
      return {ErrorCode::Permission,
              fmt::format("no permission for GPIO line '{}': {}", name,
                          how_to_get_permission(nodes.empty() ? "/dev/gpiochip0" : nodes.front())),
              code};
    }
    case ENODEV:
      return {ErrorCode::Unplugged, fmt::format("the chip of GPIO line '{}' was unplugged", name), code};
    case EINVAL:
    case ENXIO:
    case ENOTSUP:
      return {ErrorCode::Unsupported,
              fmt::format("GPIO line '{}' cannot do this: {}; choose one that has interrupts (to hear a "
                          "strobe), or that can be an output (to drive a trigger)",
                          name, std::strerror(code)),
              code};
    default:
      return {ErrorCode::Io, fmt::format("GPIO line '{}': {}", name, std::strerror(code)), code};
  }
}

#ifndef HDRCAM_HAVE_GPIOD
namespace {
Error not_built() {
  return {ErrorCode::Unsupported,
          "this hdrcam was built without libgpiod; install libgpiod-dev and build again"};
}
}  // namespace

Result<std::unique_ptr<GpioLine>> request_gpio_line(const GpioSettings&, LineDirection) {
  return not_built();
}
Result<GpioChipState> inspect_gpio_chip(const std::string&) { return not_built(); }
#endif

}  // namespace hdrcam
