// A trigger line that fails on request; it wraps a working one. Faults are counted in pulses, from 0. For
// tests. Thread-bound; it allocates nothing per edge.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "hal/clock.h"
#include "hal/trigger_line.h"

namespace hdrcam {

enum class TriggerFaultKind {
  Unseen,  // the pulse does not reach the sensor; the program does not notice
  Late,    // its first edge comes 3 ms late, as when the thread that drives it was not scheduled
  Long,    // its second edge does
  Unplug,  // from this pulse on: Unplugged
};

struct TriggerFault {
  std::uint64_t at = 0;  // the pulse
  TriggerFaultKind kind = TriggerFaultKind::Unseen;
};

class FaultyTriggerLine : public TriggerLine {
 public:
  static constexpr Duration kDelay{3'000'000};

  FaultyTriggerLine(std::unique_ptr<TriggerLine> inner, std::vector<TriggerFault> faults, Clock& clock)
      : inner_(std::move(inner)), faults_(std::move(faults)), clock_(clock) {}

  const std::string& name() const override { return inner_->name(); }
  Result<DrivenEdge> drive(LineLevel level) override;

 private:
  bool has(TriggerFaultKind kind) const;  // the pulse that is being driven

  std::unique_ptr<TriggerLine> inner_;
  std::vector<TriggerFault> faults_;
  Clock& clock_;
  std::uint64_t pulses_ = 0;  // that have ended
};

}  // namespace hdrcam
