// A whole run with the graphics device against one without.
#include "firmware_host/run/backend.h"

#include <cstdlib>
#include <filesystem>

#include "firmware_host/run/pipeline.h"
#include "hal/fault/faulty_gpu.h"
#include "tests/support/gpu.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kFrames = 12;

// HDR frames of the moving scene, as its truth's scores see them: mean squared error after the mu-law.
struct Outcome {
  double mean_squared = 0;
  int frames = 0;
  std::string fallback_reason, flow_fallback_reason, field_fallback_reason;
  int fit_steps = 0;

  double psnr_db() const { return -10 * std::log10(mean_squared / frames); }
};

double mu_law(double x) { return std::log1p(5000 * std::clamp(x, 0.0, 1.0)) / std::log1p(5000.0); }

Outcome run(GpuDevice* gpu, EmitLayer layer = EmitLayer::Merged) {
  test::MovingScene scene;
  scene.rows = 60, scene.cols = 90;
  PipelineOptions options = options_of(Preset::Fast, layer);
  WorkerPool pool(1);
  Pipeline pipeline(options, scene.camera(), pool, gpu);
  Outcome outcome;
  const Pipeline::Deliver deliver = [&](const HdrFrame& hdr, const FrameEstimate&,
                                        const FrameRecord& record) -> Result<void> {
    outcome.fit_steps += record.fit_steps;
    const double per_radiance = scene.sensitivity * hdr.reference_exposure;  // radiance 1 saturates E_ref
    double sum = 0;
    const auto index = static_cast<int>(hdr.facts.sequence);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < scene.rows; ++y)
        for (int x = 0; x < scene.cols; ++x) {
          const double truth = scene.radiance(index, c, x, y) * per_radiance;
          const double error =
              mu_law(static_cast<double>(hdr.radiance.at(c, y, x)) / 16) - mu_law(truth / 16);
          sum += error * error;
        }
    outcome.mean_squared += sum / static_cast<double>(hdr.radiance.size());
    ++outcome.frames;
    return {};
  };
  for (int i = 0; i < kFrames; ++i) REQUIRE(pipeline.take(scene.frame(i), deliver).ok());
  REQUIRE(pipeline.finish(deliver).ok());
  outcome.fallback_reason = pipeline.online().fallback_reason();
  outcome.flow_fallback_reason = pipeline.online().flow_fallback_reason();
  outcome.field_fallback_reason = pipeline.online().field_fallback_reason();
  return outcome;
}

}  // namespace

TEST_CASE("a whole run on the graphics device is as near to the truth as the processor's", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  FaultyGpu card(*gpu, {.kind = GpuKind::Discrete});  // so that a software device runs the flow, too
  const Outcome here = run(nullptr), there = run(&card);
  REQUIRE(here.frames == kFrames);
  REQUIRE(there.frames == kFrames);
  CHECK(there.fallback_reason.empty());
  CHECK(there.flow_fallback_reason.empty());
  INFO(here.psnr_db() << " dB on the processor");
  CHECK(here.psnr_db() > 20);
  CHECK(there.psnr_db() == Approx(here.psnr_db()).margin(0.02));
}

TEST_CASE("a field that the graphics device has fitted is as near to the truth as the processor's", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const Outcome here = run(nullptr, EmitLayer::Field), there = run(gpu.get(), EmitLayer::Field);
  REQUIRE(here.fit_steps > 0);
  CHECK(there.fit_steps == here.fit_steps);
  CHECK(there.field_fallback_reason.empty());
  INFO(here.psnr_db() << " dB on the processor");
  CHECK(there.psnr_db() == Approx(here.psnr_db()).margin(0.02));
}

TEST_CASE("a run whose graphics device is lost in the middle emits every frame and says why", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  FaultyGpu faulty(*gpu, {.finishes_until_lost = 9, .kind = GpuKind::Discrete});
  const Outcome here = run(nullptr), there = run(&faulty);
  CHECK(there.frames == kFrames);
  CHECK(there.fallback_reason.find("was lost") != std::string::npos);
  CHECK(there.flow_fallback_reason.find("was lost") != std::string::npos);
  CHECK(there.field_fallback_reason.find("was lost") != std::string::npos);
  CHECK(there.fit_steps == here.fit_steps);
  CHECK(there.psnr_db() == Approx(here.psnr_db()).margin(0.02));
}

TEST_CASE("the processor needs no device, and a device that is not there is a note, not an end") {
  const Backend processor = open_backend("cpu");
  CHECK(processor.gpu == nullptr);
  CHECK(processor.note.empty());
  const Backend missing = open_backend("vulkan:no such device");
  CHECK(missing.gpu == nullptr);
  CHECK(missing.note.find("computed on the processor") != std::string::npos);
}
