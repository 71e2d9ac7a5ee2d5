#include "firmware_host/run/run_sinks.h"

#include "firmware_host/film/film_plan.h"
#include "firmware_host/run/output_needs.h"

namespace hdrcam {

Result<SinkSet> open_sinks(const RunPlan& plan, const CameraFacts& camera, RunPace pace, RunControl* control,
                           Storage& storage) {
  const Settings::Output& output = plan.settings.output;
  CameraFacts filming = camera;
  if (plan.film != nullptr) filming.framerate_hz = plan.film->framerate_hz;
  return SinkSet::open(plan.sinks, output.paths,
                       {.path = "",
                        .camera = filming,
                        .layers = output.layers,
                        .compression = compression_of(output, pace),
                        .video = plan.settings.video,
                        .storage = storage,
                        .http_token = output.http_token,
                        .control = control,
                        .trace = plan.trace},
                       pace);
}

}  // namespace hdrcam
