#include "firmware_host/settings/named_knobs.h"

namespace hdrcam {

void set_named_knobs(Knobs& knobs, const Settings::Fit& fit) {
  for (const auto& [name, value] : fit.knobs) {
    const Result<void> set = set_knob(knobs, name, value);
    HDRCAM_CHECK(set.ok());
  }
}

Knobs named_knobs(const Settings::Fit& fit) {
  Knobs knobs;
  set_named_knobs(knobs, fit);
  return knobs;
}

}  // namespace hdrcam
