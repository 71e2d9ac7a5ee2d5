// Every pass of the state on the graphics device against its twin on the processor: operation by operation,
// then the whole recursion, then what happens when the device fails.
#include "online/state/vulkan/state_passes.h"

#include <cmath>

#include "hal/fault/faulty_gpu.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/warp.h"
#include "online/state/vulkan/vulkan_state.h"
#include "tests/support/cold_gpu.h"
#include "tests/support/moving_scene.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRows = 45, kCols = 70;  // odd, and no multiple of a work group

float wave(int c, int y, int x) {
  return static_cast<float>(std::sin(0.7 * x + c) * std::cos(0.43 * y) + std::sin(0.11 * (x + y)));
}

FlowField swirl(float strength) {
  FlowField flow{Image<float>(2, kRows, kCols), Image<float>(1, kRows, kCols)};
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      flow.vectors.at(0, y, x) = strength * (1.3f + wave(0, y / 3, x / 3));
      flow.vectors.at(1, y, x) = strength * wave(1, y / 3, x / 3);
      flow.confidence.at(0, y, x) = x % 9 == 0 ? 0.1f : std::min(1.f, 0.9f + 0.1f * wave(2, y, x));
    }
  return flow;
}

ExposedFrame exposed(int index) {
  test::MovingScene scene;
  scene.rows = kRows, scene.cols = kCols;
  return test::exposed(scene.frame(index), index);
}

ExposureTables tables_at(float exposure) {
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t z = 0; z < 256; ++z)
    inverse[0][z] = inverse[1][z] = inverse[2][z] = std::pow(static_cast<float>(z) / 255, 2.2f);
  VarianceExcess excess;
  for (std::size_t k = 0; k < VarianceExcess::kBins; ++k) excess.bins[1][k] = 1e-6f * static_cast<float>(k);
  return ExposureTables(Response(inverse), NoiseModel(), exposure, excess);
}

// A state that knows some pixels well, some badly and some not at all.
RadianceState some_state() {
  RadianceState state;
  state.radiance.reshape(3, kRows, kCols), state.variance.reshape(3, kRows, kCols);
  state.own_share = Image<float>(1, kRows, kCols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        state.radiance.at(c, y, x) = std::exp2(wave(c, y, x));
        state.variance.at(c, y, x) = (x + y) % 11 == 0 ? kUnseenVariance : 1e-3f * (2.1f + wave(c, x, y));
      }
  return state;
}

constexpr double kOnePass = 1e-4, kRecursion = 1e-3;  // of a sample's size

// Most samples agree to the tolerance; where a comparison falls the other way by the last bit, a few may not:
// at most one in a thousand.
void check_alike(const Image<float>& there, const Image<float>& here, const char* what,
                 double tolerance = kOnePass) {
  INFO(what);
  REQUIRE(there.same_shape(here));
  std::size_t apart = 0;
  double worst = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const float a = there.samples()[i], b = here.samples()[i];
    REQUIRE(std::isfinite(a));
    const double error =
        std::abs(static_cast<double>(a) - static_cast<double>(b)) / (1e-3 + std::abs(static_cast<double>(b)));
    worst = std::max(worst, error);
    apart += error > tolerance ? 1 : 0;
  }
  INFO("worst relative difference " << worst);
  CHECK(apart * 1000 <= here.size());
}

Image<float> planes_of(const Image<float>& stacked, int first, int count) {
  Image<float> part(count, stacked.rows(), stacked.cols());
  std::copy_n(stacked.plane(first), part.size(), part.plane(0));
  return part;
}

// A device with the passes, and pictures on it.
struct Bench {
  std::unique_ptr<GpuDevice> gpu;
  std::optional<StatePasses> passes;
  StateOptions options;

  explicit Bench(std::unique_ptr<GpuDevice> device) : gpu(std::move(device)) {
    if (gpu != nullptr) passes.emplace(value_of(StatePasses::make(*gpu, options)));
  }
  GpuPicture empty(int planes, int rows = kRows, int cols = kCols) {
    return value_of(GpuPicture::make(*gpu, planes, rows, cols));
  }
  PassRoom room() { return value_of(PassRoom::make(*gpu, kRows, kCols)); }
  GpuPicture put(std::initializer_list<const Image<float>*> parts) {
    Image<float> stacked;
    int planes = 0;
    for (const Image<float>* part : parts) planes += part->channels();
    stacked.reshape(planes, kRows, kCols);
    planes = 0;
    for (const Image<float>* part : parts) {
      std::copy(part->samples().begin(), part->samples().end(), stacked.plane(planes));
      planes += part->channels();
    }
    GpuPicture picture = empty(planes);
    upload(gpu->work(), stacked, picture);
    return picture;
  }
  GpuPicture put(const Samples& s) { return put({&s.radiance, &s.weight, &s.comparable, &s.blur}); }
  GpuPicture put(const RadianceState& s) { return put({&s.radiance, &s.variance}); }
  GpuPicture put(const FlowField& f) { return put({&f.vectors, &f.confidence}); }
  GpuTables put(const ExposureTables& tables) {
    GpuTables there = value_of(GpuTables::make(*gpu));
    there.take(tables, gpu->work());
    return there;
  }
  Image<float> get(const GpuPicture& picture) {
    Image<float> image;
    download(gpu->work(), picture, image);
    require_done(gpu->work().finish());
    return image;
  }
};

const float kUnseen = unseen_variance_from(4);

// A frame's samples against some state, with the blur modelled.
struct Scene {
  WorkerPool pool{1};
  StateOptions options;
  Fusion fusion{options.fusion, pool};
  RadianceState state = some_state();
  FlowField motion = swirl(2.5f);
  ExposedFrame frame = exposed(2);
  ExposureTables tables = tables_at(4);
  Samples samples;

  Scene() {
    fusion.sample(frame.codes, frame.codes, tables, samples);
    fusion.model_blur(state, motion.vectors, 0.5f, samples);
  }
};

}  // namespace

TEST_CASE("a warp on the graphics device is the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  const GpuPicture in = bench.put(s.state), motion = bench.put(s.motion), out = bench.empty(kStatePlanes);
  bench.passes->warp_state(in, motion, bench.room(), out);
  const Image<float> moved = bench.get(out);
  Image<float> radiance, linear, cubic;
  warp_radiance(s.state.radiance, s.motion.vectors, radiance, s.pool);
  warp_linear(s.state.variance, s.motion.vectors, linear, s.pool);
  check_alike(planes_of(moved, 0, 3), radiance, "radiance");
  check_alike(planes_of(moved, 3, 3), linear, "linear");
  bench.passes->warp(in, motion, out);
  warp_cubic(s.state.radiance, s.motion.vectors, cubic, s.pool);
  check_alike(planes_of(bench.get(out), 0, 3), cubic, "cubic");
}

TEST_CASE("the largest pixel around a place is the same on the graphics device", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  const GpuPicture in = bench.put({&s.state.radiance}), motion = bench.put(s.motion), out = bench.empty(3);
  bench.passes->largest_around(in, motion, out);
  Image<float> moved, largest;
  warp_cubic_and_largest(s.state.radiance, s.motion.vectors, moved, largest, s.pool);
  check_alike(bench.get(out), largest, "largest");
}

TEST_CASE("what does not move is copied bit for bit on the graphics device, too", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  FlowField still{Image<float>(2, kRows, kCols), Image<float>(1, kRows, kCols)};
  still.vectors.fill(0.01f);
  const GpuPicture in = bench.put(s.state), motion = bench.put(still), out = bench.empty(kStatePlanes);
  bench.passes->warp_state(in, motion, bench.room(), out);
  const Image<float> moved = bench.get(out);
  CHECK(std::equal(s.state.radiance.samples().begin(), s.state.radiance.samples().end(), moved.plane(0)));
}

TEST_CASE("a warp that leads nowhere repeats the border on the graphics device", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  for (const float wild :
       {1e9f, -1e9f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    s.motion.vectors.fill(wild);
    const GpuPicture in = bench.put(s.state), motion = bench.put(s.motion), out = bench.empty(kStatePlanes);
    bench.passes->warp_state(in, motion, bench.room(), out);
    Image<float> cubic;
    warp_radiance(s.state.radiance, s.motion.vectors, cubic, s.pool);
    check_alike(planes_of(bench.get(out), 0, 3), cubic, "wild");
  }
}

TEST_CASE("means and local contrast on the graphics device are the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  const GpuPicture in = bench.put({&s.state.radiance}), out = bench.empty(3), contrast = bench.empty(3);
  Image<float> mean, variance;
  for (const int radius : {1, 2}) {
    bench.passes->box_mean(in, radius, out);
    box_mean(s.state.radiance, radius, mean, s.pool);
    check_alike(bench.get(out), mean, "box");
  }
  bench.passes->local_contrast(in, out, contrast);
  local_contrast(s.state.radiance, mean, variance, s.pool);
  check_alike(bench.get(out), mean, "mean");
  check_alike(bench.get(contrast), variance, "contrast");
}

TEST_CASE("samples on the graphics device are the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  const GpuPicture codes = bench.put({&s.frame.codes}), out = bench.empty(kSamplePlanes);
  bench.passes->sample(codes, codes, bench.put(s.tables), out);
  const Image<float> found = bench.get(out);
  Samples here;
  s.fusion.sample(s.frame.codes, s.frame.codes, s.tables, here);
  check_alike(planes_of(found, 0, 3), here.radiance, "radiance");
  check_alike(planes_of(found, 3, 3), here.weight, "weight");
  check_alike(planes_of(found, 6, 3), here.comparable, "comparable");
  CHECK_FALSE(here.blurred);
  here.blur.fill(0);
  check_alike(planes_of(found, 9, 3), here.blur, "blur");
}

TEST_CASE("the blur of an exposure on the graphics device is the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  for (const float fraction : {0.02f, 0.3f, 1.f}) {
    Samples here;
    s.fusion.sample(s.frame.codes, s.frame.codes, s.tables, here);
    here.blur.fill(0);
    const GpuPicture samples = bench.put(here);
    bench.passes->model_blur(bench.put(s.state), bench.put(s.motion), fraction, samples);
    s.fusion.model_blur(s.state, s.motion.vectors, fraction, here);
    if (!here.blurred) here.blur.fill(0);
    // a small difference of large values
    check_alike(planes_of(bench.get(samples), 9, 3), here.blur, "blur", kRecursion);
  }
}

TEST_CASE("the gate on the graphics device is the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  const GpuPicture state = bench.put(s.state), gate = bench.empty(1), contrast = bench.empty(3);
  const PassRoom room = bench.room();
  bench.passes->gate({state, bench.put(s.samples), bench.put(s.tables), kUnseen}, bench.put(s.motion), room,
                     gate, contrast);
  Image<float> here, local;
  s.fusion.gate({s.state, s.samples, s.tables, kUnseen}, s.motion.confidence, here, local);
  check_alike(bench.get(gate), here, "gate");
  check_alike(bench.get(contrast), local, "contrast");
}

TEST_CASE("an update of the state on the graphics device is the processor's", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  s.tables.set_texture_error(0.1f);
  const GpuPicture state = bench.put(s.state), share = bench.empty(1);
  const PassRoom room = bench.room();
  bench.passes->update({state, bench.put(s.samples), bench.put(s.tables), kUnseen}, room, share);
  const Image<float> there = bench.get(state);
  Image<float> own;
  RadianceState updated;
  s.fusion.update({s.state, s.samples, s.tables, kUnseen}, nullptr, nullptr, updated, own);
  check_alike(planes_of(there, 0, 3), updated.radiance, "radiance");
  check_alike(planes_of(there, 3, 3), updated.variance, "variance");
  check_alike(bench.get(share), own, "share");
}

TEST_CASE("later samples join the state on the graphics device as on the processor", "[gpu]") {
  Bench bench(test::open_test_gpu());
  NEEDS_GPU(bench.gpu);
  Scene s;
  Image<float> gate(1, kRows, kCols), mean, contrast, share;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) gate.at(0, y, x) = 0.5f + 0.25f * wave(0, y, x);
  local_contrast(s.state.radiance, mean, contrast, s.pool);
  s.tables.set_texture_error(0.1f);
  const GpuPicture state = bench.put(s.state), joined = bench.empty(1);
  const PassRoom room = bench.room();
  bench.gpu->work().clear(*joined.buffer);
  bench.passes->join({state, bench.put(s.samples), bench.put(s.tables), kUnseen}, bench.put({&gate}),
                     {bench.put({&contrast}), bench.put(s.motion)}, room, joined);
  const Image<float> there = bench.get(state);
  RadianceState updated;
  const Moved moved{contrast, s.motion.vectors};
  s.fusion.update({s.state, s.samples, s.tables, kUnseen}, &gate, &moved, updated, share);
  check_alike(planes_of(there, 0, 3), updated.radiance, "radiance");
  check_alike(planes_of(there, 3, 3), updated.variance, "variance");
  check_alike(bench.get(joined), share, "share");
}

namespace {

// Both layers through the same frames; what they hold at each is compared.
struct TwoLayers {
  WorkerPool pool{1};
  CpuState here{StateOptions(), kRows, kCols, pool};
  VulkanState there;
  ExposureTables tables[3] = {tables_at(0.25f), tables_at(1), tables_at(4)};
  FlowField motion = swirl(0.8f), onward = swirl(-0.7f);
  ExposedFrame frames[8];

  explicit TwoLayers(GpuDevice& gpu) : there(StateOptions(), kRows, kCols, pool, gpu) {
    for (int i = 0; i < 8; ++i) frames[i] = exposed(i);
  }
  StateInput input(int i) { return {frames[i], tables[i % 3], kUnseen}; }
  void take(int i) {
    for (StateLayer* layer : {static_cast<StateLayer*>(&here), static_cast<StateLayer*>(&there)})
      i == 0 ? layer->restart(input(i)) : layer->advance(input(i), motion);
  }
  void compare() {
    check_alike(there.state().radiance, here.state().radiance, "radiance", kRecursion);
    check_alike(there.state().variance, here.state().variance, "variance", kRecursion);
    check_alike(there.state().own_share, here.state().own_share, "own share", kRecursion);
  }
  void join_after(int i, std::size_t ahead, const RadianceState* earlier = nullptr) {
    const LaterFrame later[2] = {{&frames[i + 1], &onward, &tables[(i + 1) % 3], i % 2 == 1},
                                 {&frames[i + 2], &onward, &tables[(i + 2) % 3]}};
    JoinedState a, b;
    here.join(earlier ? *earlier : here.state(), {later, ahead}, kUnseen, a);
    there.join(earlier ? *earlier : there.state(), {later, ahead}, kUnseen, b);
    check_alike(b.radiance, a.radiance, "joined radiance", kRecursion);
    check_alike(b.variance, a.variance, "joined variance", kRecursion);
    check_alike(b.later_share, a.later_share, "later share", kRecursion);
  }
};

}  // namespace

TEST_CASE("a state that runs on the graphics device knows what the processor's does", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  TwoLayers both(*gpu);
  RadianceState earlier;
  for (int i = 0; i < 6; ++i) {
    both.take(i);
    INFO("frame " << i);
    both.compare();
    both.join_after(i, static_cast<std::size_t>(1 + i % 2));
    if (i == 3) earlier.copy_from(both.here.state());
  }
  both.join_after(4, 2, &earlier);
  for (const float exposure : {0.25f, 1.f, 4.f})
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < VarianceExcess::kBins; ++k) {
        const float there = both.there.residuals().excess(exposure).bins[c][k];
        const float here = both.here.residuals().excess(exposure).bins[c][k];
        CHECK(there == Approx(here).epsilon(0.05).margin(1e-6));
      }
  CHECK(both.there.fallback_reason().empty());
}

TEST_CASE("by day after a night, what is clipped is called unseen on the graphics device, too", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  constexpr float kDay = 4e-6f;
  TwoLayers both(*gpu);
  const ExposureTables tables[2] = {tables_at(1), tables_at(kDay)};
  for (int i = 0; i < 6; ++i) {
    INFO("frame " << i);
    ExposedFrame& frame = both.frames[i];
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) frame.codes.at(c, y, x) = x < kCols / 2 || i < 5 ? kMaxCode : 128.f;
    const float unseen = unseen_variance_from(i == 0 ? 1 : 1 / kDay);
    const StateInput input{frame, tables[i % 2], unseen};
    for (StateLayer* layer : {static_cast<StateLayer*>(&both.here), static_cast<StateLayer*>(&both.there)})
      i == 0 ? layer->restart(input) : layer->advance(input, both.motion);
    both.compare();
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y) {
        REQUIRE(both.there.state().variance.at(c, y, 1) >= unseen);
        REQUIRE(both.there.state().radiance.at(c, y, 1) == Approx(i == 0 ? 1 : 1 / kDay));
      }
  }
  const float seen = tables[1].radiance(1, 128);
  CHECK(both.there.state().radiance.at(1, 9, kCols - 9) == Approx(seen).epsilon(0.01));
  CHECK(both.there.state().variance.at(1, 9, kCols - 9) < 0.01f * seen * seen);
  CHECK(both.there.fallback_reason().empty());
}

TEST_CASE("after a restart a frame's codes go to the graphics device anew", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  TwoLayers both(*gpu);
  both.take(0);
  both.join_after(0, 2);  // 1 and 2 are there
  for (int i = 0; i < 3; ++i) both.frames[i] = exposed(i + 3), both.frames[i].index = i;
  for (int i = 0; i < 3; ++i) {
    INFO("frame " << i);
    both.take(i);
    both.compare();
  }
}

TEST_CASE(
    "a graphics device without memory, for pictures or for kernels, leaves the state to the processor, to "
    "the same bytes",
    "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const auto check = [&](const GpuFaults& faults, const char* reason) {
    FaultyGpu faulty(*gpu, faults);
    TwoLayers both(faulty);
    CHECK(both.there.fallback_reason().find(reason) != std::string::npos);
    for (int i = 0; i < 4; ++i) both.take(i);
    const auto a = both.here.state().radiance.samples(), b = both.there.state().radiance.samples();
    CHECK(std::equal(a.begin(), a.end(), b.begin()));
  };
  check({.buffers_until_full = 5}, "memory is full");
  check({.kernels_until_refused = 3}, "compiler has no memory");
}

TEST_CASE("a graphics device lost at any moment loses no frame: the processor goes on from there", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  for (int lost = 0; lost < 8; ++lost) {
    INFO("lost after " << lost << " pieces of work");
    FaultyGpu faulty(*gpu, {.finishes_until_lost = lost});
    TwoLayers both(faulty);
    for (int i = 0; i < 5; ++i) {
      both.take(i);
      both.compare();
      both.join_after(i, 1);
    }
    CHECK(both.there.fallback_reason().find("was lost") != std::string::npos);
  }
}

TEST_CASE("the checks of Vulkan find nothing wrong with the state's passes", "[gpu]") {
  test::CheckedGpu checked;
  if (checked.gpu == nullptr) return;
  {
    TwoLayers both(*checked.gpu);
    for (int i = 0; i < 5; ++i) {
      both.take(i);
      both.join_after(i, 2);
    }
    CHECK(both.there.fallback_reason().empty());
  }
  checked.expect_no_complaints();
}

TEST_CASE("the state's kernels are compiled and have run once within three seconds of processor time",
          "[gpu]") {
  const test::ColdGpu cold;
  NEEDS_GPU(cold.gpu);
  TwoLayers both(*cold.gpu);
  for (int i = 0; i < 2; ++i) both.there.restart(both.input(i));
  both.there.advance(both.input(2), both.motion);
  JoinedState joined;
  const LaterFrame later[2] = {{&both.frames[3], &both.onward, &both.tables[0]},
                               {&both.frames[4], &both.onward, &both.tables[1]}};
  both.there.join(both.there.state(), later, kUnseen, joined);
  CHECK(both.there.fallback_reason().empty());
  CHECK(cold.seconds() < 3);
}
