#include "hal/fault/faulty_trigger_line.h"

#include <algorithm>

namespace hdrcam {

bool FaultyTriggerLine::has(TriggerFaultKind kind) const {
  return std::any_of(faults_.begin(), faults_.end(), [&](const TriggerFault& fault) {
    return fault.kind == kind &&
           (fault.at == pulses_ || (kind == TriggerFaultKind::Unplug && fault.at < pulses_));
  });
}

Result<DrivenEdge> FaultyTriggerLine::drive(LineLevel level) {
  const bool rises = level == LineLevel::Active;
  if (has(TriggerFaultKind::Unplug))
    return Error{ErrorCode::Unplugged, "the trigger line went away (injected fault)"};
  if (has(rises ? TriggerFaultKind::Late : TriggerFaultKind::Long)) clock_.sleep_until(clock_.now() + kDelay);
  const bool unseen = has(TriggerFaultKind::Unseen);
  pulses_ += rises ? 0 : 1;
  if (unseen) return DrivenEdge{clock_.now(), Duration(0)};
  return inner_->drive(level);
}

}  // namespace hdrcam
