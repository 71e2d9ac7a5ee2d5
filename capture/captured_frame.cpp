#include "capture/captured_frame.h"

#include <fmt/format.h>

namespace hdrcam {

void CaptureCounters::count(const Judgement& judgement) {
  switch (judgement.verdict) {
    case Verdict::Proved:
      ++proved;
      break;
    case Verdict::Plausible:
      ++plausible;
      break;
    case Verdict::Estimated:
      ++estimated;
      break;
    case Verdict::Contradicted:
      ++contradicted;
      break;
    case Verdict::Unknown:
      ++unknown;
      break;
  }
  relabelled += judgement.relabelled;
}

std::string proof_of(const CaptureCounters& counters) {
  std::string text = fmt::format(
      "exposures: {} proved, {} plausible, {}{} contradicted, {} unknown", counters.proved,
      counters.plausible, counters.estimated > 0 ? fmt::format("{} estimated, ", counters.estimated) : "",
      counters.contradicted, counters.unknown);
  if (counters.pulses_forgotten > 0)
    text += fmt::format("; frames taken too late for their strobe or trigger pulses: {}",
                        counters.pulses_forgotten);
  if (counters.controls_late > 0)
    text += fmt::format("; frames whose exposure was written late or never: {}", counters.controls_late);
  return text;
}

}  // namespace hdrcam
