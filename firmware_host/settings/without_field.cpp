#include "firmware_host/settings/without_field.h"

#include "firmware_host/settings/named_knobs.h"

namespace hdrcam {

const char* what_leaves_out_field(const Settings::Fit& fit) {
  if (named_knobs(fit).field == FieldKind::None) return "--set field=none";
  return fit.emit == EmitLayer::State ? "--emit state" : "";
}

}  // namespace hdrcam
