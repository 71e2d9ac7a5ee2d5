#include "firmware_host/settings/without_field.h"

namespace hdrcam {

const char* what_leaves_out_field(const Settings::Fit& fit) {
  const auto field = fit.knobs.find("field");
  if (field != fit.knobs.end() && field->second == "none") return "--set field=none";
  return fit.emit == EmitLayer::State ? "--emit state" : "";
}

}  // namespace hdrcam
