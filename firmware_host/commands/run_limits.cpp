#include "firmware_host/commands/run_limits.h"

#include "firmware_host/settings/seconds_text.h"
#include "hal/core/counted.h"
#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

constexpr double kLongestRun_s = 1e9;
constexpr int kMostFrames = 1'000'000'000;

}  // namespace

WordCheck counts_frames() {
  return [](const std::string& text) {
    const auto frames = parse_number<std::int64_t>(text);
    const bool sound = frames && *frames >= 1 && *frames <= kMostFrames;
    return sound ? std::string()
                 : fmt::format("takes a number of frames, 1 to {}, not '{}'", kMostFrames, text);
  };
}

void RunLimits::add_to(CommandLine verb) {
  verb.add_option("--frames", frames, "frames to capture [until ^C]").check(counts_frames());
  const auto in_seconds = [](const std::string& text) {
    const auto seconds = seconds_of(text);
    return seconds && *seconds > 0 ? fmt::format("{}", *seconds) : text;  // else to be refused as it is
  };
  verb.add_option("--timeout", timeout_s, "length of the run, such as 90s, or a number of seconds [until ^C]")
      .type_name("TEXT")
      .transform(in_seconds)
      .check([](const std::string& text) {
        const auto seconds = parse_number<double>(text);
        const bool possible = seconds && *seconds > 0 && *seconds <= kLongestRun_s,
                   sound = possible && from_seconds(*seconds) > Duration::zero();  // 0 would be no limit
        return sound ? std::string()
                     : fmt::format(
                           "takes a duration such as 90s, or a number of seconds, more than 0 and at most "
                           "{:.0f} (30 years), not '{}'",
                           kLongestRun_s, text);
      });
}

LiveOptions RunLimits::options(LiveWork work) const {
  return {.frames = frames, .timeout = from_seconds(timeout_s), .work = work};
}

Result<void> RunLimits::ended_by(LiveEnd end, std::uint64_t captured) const {
  if (end == LiveEnd::Timeout && captured == 0)
    return Error{ErrorCode::Timeout, "no frame came within --timeout; give more time"};
  const bool limited = frames > 0 || timeout_s > 0;
  if (end != LiveEnd::Stopped || !limited) return {};
  return Error{ErrorCode::Interrupted,
               fmt::format("stopped after {}; the files that were written are complete",
                           counted(captured, "captured frame"))};
}

}  // namespace hdrcam
