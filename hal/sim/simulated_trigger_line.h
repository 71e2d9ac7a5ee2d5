// The end of a simulated wire that the processor drives. Thread-bound; the wire outlives it.
#pragma once

#include "hal/sim/simulated_sync_line.h"
#include "hal/trigger_line.h"

namespace hdrcam {

class SimulatedTriggerLine : public TriggerLine {
 public:
  explicit SimulatedTriggerLine(SimulatedWire& wire) : wire_(wire) {}
  ~SimulatedTriggerLine() override { (void)wire_.drive(false); }

  const std::string& name() const override { return name_; }
  Result<DrivenEdge> drive(LineLevel level) override {
    return DrivenEdge{wire_.drive(level == LineLevel::Active), Duration(0)};
  }

 private:
  SimulatedWire& wire_;
  std::string name_ = "sim";
};

}  // namespace hdrcam
