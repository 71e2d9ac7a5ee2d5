// A command line, one word a line, as far as it is read before anything is done; and the texts that some
// words hold: exposures, delays, scenes, patterns.
#include <string>
#include <vector>

#include "capture/exposure.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/program.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "hal/sim/simulation.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  if (words.size() > 64) return 0;
  std::vector<const char*> args;
  for (const std::string& word : words) args.push_back(word.c_str());
  (void)parse_command_line(args);
  for (const std::string& word : words) {
    (void)parse_exposures(word, "");
    (void)parse_exposures("1ms,4ms", word);
    (void)parse_duration(word);
    (void)parse_delays(word);
    (void)simulation_of(word);
    if (const auto pattern = FramePattern::parse("--output", word, ".exr")) (void)pattern.value().path(41);
  }
  return 0;
}
