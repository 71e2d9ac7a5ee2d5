// One GPIO line of libgpiod, with one implementation for version 1 and one for version 2 of that library.
// Thread-bound.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/instant.h"
#include "hal/core/result.h"
#include "hal/trigger_line.h"

namespace hdrcam {

struct GpioSettings {
  std::string line;  // "gpiochip0:17", or the line's own name ("STROBE")
  bool active_low = false;
};

enum class LineDirection { Input, Output };

struct GpioEvent {
  bool rising = true;
  Duration stamp{0};                           // of the monotonic clock; real time with kernels before 5.7
  std::optional<std::uint64_t> line_sequence;  // the kernel's counter, where it has one
};

class GpioLine {
 public:
  virtual ~GpioLine() = default;
  virtual Result<void> set(LineLevel level) = 0;
  virtual int event_fd() const = 0;  // readable when an edge is there
  virtual Result<GpioEvent> read_event() = 0;
};

struct GpioLineName {
  std::string chip;     // "gpiochip0"
  unsigned offset = 0;  // on the chip
};

// An output is inactive at first. NotFound, Permission, Busy (names the holder), Unsupported.
Result<std::unique_ptr<GpioLine>> request_gpio_line(const GpioSettings& settings, LineDirection direction);

enum class GpioLineUse { Free, Held, Unreadable };

struct GpioLineState {
  std::string name = {};  // "" for none
  GpioLineUse use = GpioLineUse::Free;
  std::string consumer = {};  // who holds it; "" where the kernel names none
  bool output = false;
};
struct GpioChipState {
  std::string name, label;
  std::vector<GpioLineState> lines;
};
Result<GpioChipState> inspect_gpio_chip(const std::string& node);

// For both versions: the lines of a chip by their numbers. One whose state cannot be read (nullopt) stays in
// the list as unreadable, so that those behind it keep their numbers.
std::vector<GpioLineState> lines_by_number(
    unsigned count, const std::function<std::optional<GpioLineState>(unsigned)>& state_of);
// For a list of lines: "gpiochip0:17 STROBE, output, held by 'led'"; "" for one that is unnamed and free.
std::string describe(const GpioLineState& line, const std::string& chip, std::size_t number);
// For both versions: splits "gpiochip0:17"; nullopt for anything else.
std::optional<GpioLineName> parse_line_name(const std::string& name);
// Whether two names are those of one line: "gpiochip0:17" and "FSYNC". Lines that are not there differ.
bool same_gpio_line(const std::string& a, const std::string& b);
// The nodes of all GPIO chips, "/dev/gpiochip0" first.
std::vector<std::string> gpio_chip_nodes();
Error line_error(int code, const std::string& name, const std::string& consumer);

}  // namespace hdrcam
