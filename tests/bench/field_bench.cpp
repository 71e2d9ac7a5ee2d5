// What a step and a picture of the field cost on this machine: processor time of one thread, best of several runs.
//   ninja hdrcam_bench && HDRCAM_ISA=avx2 ./tests/hdrcam_bench
#include <fmt/format.h>
#include <time.h>

#include "hal/core/cpu.h"
#include "render/field_renderer.h"
#include "tests/online/fit/moving_scene.h"

using namespace hdrcam;

namespace {

double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

template <class Body>
double best_ms(int runs, Body&& body) {
  double best = 1e30;
  for (int i = 0; i < runs; ++i) {
    const double start = processor_ms();
    body();
    best = std::min(best, processor_ms() - start);
  }
  return best;
}

void measure(const char* name, FieldOptions options) {
  MovingScene scene;
  scene.rows = 240, scene.cols = 320;
  WorkerPool pool(1);
  options.samples_without_parallax = options.samples_per_ray;
  FieldFit fit(options, {}, scene.rows, scene.cols, pool);
  double observe_ms = 1e30;
  for (int i = 0; i < 6; ++i) {
    const FieldObservation seen = scene.frame(i);
    observe_ms = std::min(observe_ms, best_ms(1, [&] { CHECK_OK(fit.observe(seen, scene.response)); }));
  }
  const double step_ms = best_ms(100, [&] { fit.step(); });
  FieldRenderer renderer(pool);
  FieldView view;
  const double render_ms = best_ms(5, [&] { renderer.render(fit.field(), {kIdentityPose, 5 / 30.0, 2}, view); });
  fmt::print("{:9} {} rays x {} samples: step {:.2f} ms, 160x120 picture {:.1f} ms, observe 320x240 {:.1f} ms\n", name,
             options.rays_per_step, options.samples_per_ray, step_ms, render_ms, observe_ms);
}

}  // namespace

int main() {
  flush_denormals();
  fmt::print("instruction set {}\n", name(instruction_set()));
  measure("fast", FieldOptions::fast());
  measure("balanced", FieldOptions::balanced());
  measure("best", FieldOptions::best());
}
