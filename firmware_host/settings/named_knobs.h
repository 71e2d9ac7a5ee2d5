// The knobs of the method that the settings set by name, as values. Reentrant.
#pragma once

#include "firmware_host/settings/settings.h"
#include "online/knobs.h"

namespace hdrcam {

// Sets those that the settings name, which were checked when they were read (setting_field.h).
void set_named_knobs(Knobs& knobs, const Settings::Fit& fit);
// The same on the knobs of no preset: what the user named has its value, all else its default.
Knobs named_knobs(const Settings::Fit& fit);

}  // namespace hdrcam
