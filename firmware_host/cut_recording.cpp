#include "firmware_host/cut_recording.h"

#include <fmt/format.h>

#include "firmware_host/command_line.h"
#include "hal/core/counted.h"

namespace hdrcam {

Error cut_recording(Error error, const std::string& path, std::uint64_t frames) {
  if (frames == 0 || error.code == ErrorCode::NotFound) return error;  // NotFound: it was removed
  error.message +=
      fmt::format("; '{}' is cut after {}, of which 'hdrcam repair {} -o FILE' makes a complete recording",
                  path, counted(frames, "frame"), shell_word(path));
  return error;
}

Error read_to_cut(Error error, const std::string& path) {
  error.message +=
      fmt::format("; 'hdrcam repair {} -o FILE' makes a complete recording of them", shell_word(path));
  return error;
}

}  // namespace hdrcam
