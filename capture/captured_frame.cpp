#include "capture/captured_frame.h"

namespace hdrcam {

void CaptureCounters::count(const Judgement& judgement) {
  switch (judgement.verdict) {
    case Verdict::Proved:
      ++proved;
      break;
    case Verdict::Plausible:
      ++plausible;
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

}  // namespace hdrcam
