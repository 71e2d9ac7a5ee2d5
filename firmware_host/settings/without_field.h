// Whether the settings leave out the radiance field, which depth, other views and the field's motion need.
// Reentrant.
#pragma once

#include "firmware_host/settings/settings.h"

namespace hdrcam {

// The setting that leaves out the field, as a user writes it: "--emit state"; "" where none does.
const char* what_leaves_out_field(const Settings::Fit& fit);

}  // namespace hdrcam
