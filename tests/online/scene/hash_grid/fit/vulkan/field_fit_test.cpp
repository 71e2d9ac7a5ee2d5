// Whole fits whose steps run on the graphics device, beside the processor's: what they learn, that they
// repeat, and what becomes of them when the device fails.
#include "online/scene/hash_grid/fit/field_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/fault/faulty_gpu.h"
#include "online/scene/hash_grid/field/field_renderer.h"
#include "tests/online/scene/hash_grid/fit/fit_stream.h"
#include "tests/support/cold_gpu.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

struct Stream {
  WorkerPool pool;
  FitStream scene;
  FieldFit fit;
  std::vector<StepReport> reports;
  double last_time_s = 0;

  explicit Stream(GpuDevice* gpu, const FieldOptions& options = FitStream::small_options(), int threads = 1)
      : pool(threads), fit(options, {}, scene.rows, scene.cols, pool, gpu) {
    fit.prepare(FitStream::small_budget());
  }
  // With a camera that moves sideways where `parallax` says so.
  void take(int i, int steps, bool parallax = false) {
    FieldObservation seen = scene.frame(i, 0.05f, true);
    if (parallax) seen.T_world_camera.t.x() = 0.12 * i;
    REQUIRE(fit.observe(seen, scene.response).ok());
    last_time_s = seen.time_s;
    for (int s = 0; s < steps; ++s) reports.push_back(fit.step());
    fit.settle();
  }
  Image<float> radiance() {
    FieldRenderer renderer;
    FieldPicture picture;
    renderer.render(fit.field(), FitStream::view(fit, {}, last_time_s, 1), pool, picture);
    return picture.radiance.clone();
  }
  std::vector<float> parameters() const {
    std::vector<float> all;
    for (const Branch<float>* branch : {&fit.field().networks.static_, &fit.field().networks.dynamic}) {
      const auto tables = branch->grid.tables().samples();
      all.insert(all.end(), tables.begin(), tables.end());
      all.insert(all.end(), branch->mlp.parameters().begin(), branch->mlp.parameters().end());
    }
    return all;
  }
};

double log_apart(const Image<float>& a, const Image<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += std::abs(std::log(static_cast<double>(a.samples()[i]) / static_cast<double>(b.samples()[i])));
  return sum / static_cast<double>(a.size());
}

// The same steps, and nearly the same losses and pictures: rounding grows from step to step. Where there is
// nothing to learn rounding decides what is left of a loss, which then jumps; only there it has a margin.
void check_alike(Stream& there, Stream& here) {
  REQUIRE(there.reports.size() == here.reports.size());
  const bool learns = std::ranges::max(here.reports, {}, &StepReport::total).total > 1e-3;
  for (std::size_t s = 0; s < here.reports.size(); ++s) {
    INFO("step " << s);
    REQUIRE(there.reports[s].verdict == here.reports[s].verdict);
    REQUIRE(there.reports[s].total == Approx(here.reports[s].total).epsilon(2e-3).margin(learns ? 0 : 1e-5));
    REQUIRE(there.reports[s].gradient_norm ==
            Approx(here.reports[s].gradient_norm).epsilon(5e-3).margin(learns ? 0 : 2e-3));
  }
  CHECK(log_apart(there.radiance(), here.radiance()) < 1e-4);
}

}  // namespace

TEST_CASE("a fit on the graphics device takes the processor's steps", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  for (const bool parallax : {false, true})
    for (const float speed_px : {1.5f, 0.f})
      for (const bool fits_response : {false, true}) {
        INFO("parallax " << parallax << ", speed " << speed_px << ", response " << fits_response);
        FieldOptions options = FitStream::small_options();
        options.fits_response = fits_response;
        Stream here(nullptr, options), there(gpu.get(), options);
        for (Stream* stream : {&here, &there}) {
          stream->scene.speed_px = speed_px;
          // until the anchor has moved, where the camera does
          for (int i = 0; i < 9; ++i) stream->take(i, 6, parallax);
        }
        CHECK(there.fit.fallback_reason().empty());
        CHECK(there.fit.counts().steps == here.fit.counts().steps);
        CHECK(there.fit.counts().without_dynamic == here.fit.counts().without_dynamic);
        CHECK(there.fit.counts().anchors_moved == (parallax ? here.fit.counts().anchors_moved : 0));
        check_alike(there, here);
        Stream untaught(nullptr, options);
        untaught.scene.speed_px = speed_px;
        for (int i = 0; i < 9; ++i) untaught.take(i, 0, parallax);
        CHECK(log_apart(there.radiance(), here.radiance()) <
              0.05 * log_apart(untaught.radiance(), here.radiance()));
      }
}

TEST_CASE("a fit on the graphics device gives the same bytes again, for any number of threads", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const auto learned = [&](int threads) {
    Stream stream(gpu.get(), FitStream::small_options(), threads);
    for (int i = 0; i < 4; ++i) stream.take(i, 7);
    CHECK(stream.fit.fallback_reason().empty());
    return stream.parameters();
  };
  const std::vector<float> once = learned(1);
  CHECK((learned(1) == once));
  CHECK((learned(3) == once));
}

TEST_CASE("a step that goes wrong on the graphics device changes no parameter, and is counted", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  FieldOptions options = FitStream::small_options();
  SECTION("not a number") {
    options.losses[static_cast<std::size_t>(LossTerm::Combined)] = std::numeric_limits<float>::quiet_NaN();
    Stream stream(gpu.get(), options);
    for (int i = 0; i < 3; ++i) stream.take(i, 0);
    const std::vector<float> before = stream.parameters();
    for (int s = 0; s < 5; ++s) CHECK(stream.fit.step().verdict == StepVerdict::Skipped);
    stream.fit.settle();
    CHECK(stream.fit.counts().skipped == 5);
    CHECK((stream.parameters() == before));
    CHECK(stream.fit.fallback_reason().empty());
  }
  SECTION("exploded") {
    options.losses[static_cast<std::size_t>(LossTerm::TemporalSmoothness)] = 0.1f;
    Stream stream(gpu.get(), options);
    const auto observe = [&](int i) {
      const FieldObservation seen = stream.scene.frame(i);
      // two frames whose flow leads 300 pixels away, everywhere
      if (i == 4) std::fill_n(stream.scene.to_previous.vectors.plane(0), 32 * 48, 300.f);
      if (i == 5) std::fill_n(stream.scene.from_previous.vectors.plane(0), 32 * 48, 300.f);
      REQUIRE(stream.fit.observe(seen, stream.scene.response).ok());
    };
    for (int i = 0; i < 7; ++i) {
      observe(i);
      if (i < 4)
        for (int s = 0; s < 20; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
      stream.fit.settle();
    }
    const std::vector<float> learned = stream.parameters();
    for (int s = 0; s + 1 < FitHealth::kPatience; ++s) {
      REQUIRE(stream.fit.step().verdict == StepVerdict::RolledBack);
      stream.fit.settle();
      CHECK((stream.parameters() == learned));
    }
    REQUIRE(stream.fit.step().verdict == StepVerdict::RolledBack);
    CHECK(stream.fit.counts().restarted == 1);
    CHECK((stream.parameters() != learned));
    // and it goes on, there
    observe(8);
    for (int s = 0; s < 5; ++s) CHECK(stream.fit.step().verdict == StepVerdict::Taken);
    stream.fit.settle();
    CHECK(stream.fit.fallback_reason().empty());
  }
}

TEST_CASE("a graphics device without memory leaves the fit to the processor, to the same bytes", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  Stream here(nullptr);
  for (int i = 0; i < 3; ++i) here.take(i, 4);
  for (const int buffers : {0, 5, 26, 39}) {  // the last two leave no room for a step
    INFO(buffers << " buffers");
    FaultyGpu faulty(*gpu, {.buffers_until_full = buffers});
    Stream there(&faulty);
    for (int i = 0; i < 3; ++i) there.take(i, 4);
    CHECK(there.fit.fallback_reason().find("memory is full") != std::string::npos);
    CHECK((there.parameters() == here.parameters()));
  }
}

TEST_CASE("a graphics device that compiles no kernel leaves the fit to the processor, to the same bytes",
          "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  Stream here(nullptr);
  FaultyGpu faulty(*gpu, {.kernels_until_refused = 4});
  Stream there(&faulty);
  for (Stream* stream : {&here, &there})
    for (int i = 0; i < 3; ++i) stream->take(i, 4);
  CHECK(there.fit.fallback_reason().find("compiler has no memory") != std::string::npos);
  CHECK((there.parameters() == here.parameters()));
}

TEST_CASE("a graphics device lost at any moment loses no step: the processor takes the frame's again",
          "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  constexpr int kSteps = 3, kFinishes = 1 + 2 * kSteps + 1;  // of a frame: begin, two a step, collect
  Stream here(nullptr);
  for (int i = 0; i < 3; ++i) here.take(i, kSteps);
  for (int lost = 0; lost < 3 * kFinishes; ++lost) {
    INFO("lost after " << lost << " pieces of work");
    FaultyGpu faulty(*gpu, {.finishes_until_lost = lost});
    Stream there(&faulty);
    for (int i = 0; i < 3; ++i) there.take(i, kSteps);
    CHECK(there.fit.fallback_reason().find("was lost") != std::string::npos);
    CHECK(there.fit.counts().steps == here.fit.counts().steps);
    if (lost < kFinishes)
      CHECK((there.parameters() == here.parameters()));
    else
      check_alike(there, here);
  }
}

TEST_CASE("the checks of Vulkan find nothing wrong with the fit", "[gpu]") {
  test::CheckedGpu checked;
  if (checked.gpu == nullptr) return;
  {
    Stream stream(checked.gpu.get());
    for (int i = 0; i < 4; ++i) stream.take(i, 3, true);
    CHECK(stream.fit.fallback_reason().empty());
  }
  checked.expect_no_complaints();
}

TEST_CASE("the fit's kernels are compiled and have run once within three seconds of processor time",
          "[gpu]") {
  const test::ColdGpu cold;
  NEEDS_GPU(cold.gpu);
  Stream stream(cold.gpu.get());
  for (int i = 0; i < 2; ++i) stream.take(i, 1);
  CHECK(stream.fit.fallback_reason().empty());
  CHECK(cold.seconds() < 3);
}
