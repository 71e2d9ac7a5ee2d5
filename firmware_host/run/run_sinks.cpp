#include "firmware_host/run/run_sinks.h"

#include "firmware_host/film/film_plan.h"
#include "firmware_host/run/output_needs.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {

Result<SinkSet> open_sinks(const RunPlan& plan, const CameraFacts& camera, RunPace pace, RunControl* control,
                           Storage& storage) {
  const Settings::Output& output = plan.settings.output;
  CameraFacts filming = camera;
  if (plan.film != nullptr) {
    const int eyes = plan.film->baseline > 0 ? 2 : 1;  // side by side
    filming.framerate_hz = plan.film->framerate_hz;
    filming.width = eyes * plan.film->width, filming.height = plan.film->height;
  }
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

Result<void> fed_by(const std::function<Result<void>()>& work, SinkSet& sinks) {
  Result<void> worked;
  const std::exception_ptr thrown = thrown_by([&] { worked = work(); });
  if (thrown == nullptr) return worked;
  (void)thrown_by([&] { (void)sinks.finish(); });
  std::rethrow_exception(thrown);
}

}  // namespace hdrcam
