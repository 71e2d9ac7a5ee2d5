// The passes of the dense flow on the graphics device, each against the kernel of the processor that it is
// the twin of. start and enlarge, whose twins are private, only within whole flows: vulkan_flow_test.cpp.
#include "online/priors/motion/vulkan/flow_passes.h"

#include <cmath>

#include "online/priors/motion/flow_effort.h"
#include "online/priors/motion/refinement_kernels.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRows = 61, kCols = 90;

float code_at(float x, float y) {
  return 128 + 50 * std::sin(0.31f * x + 0.1f * y) * std::cos(0.23f * y) + 30 * std::sin(0.7f * y - 0.4f * x);
}

// A picture on the processor, with its border and derivatives.
struct Picture {
  Image<float> planes;
  FlowPicture view{};

  Picture(float du, float dv, int rows = kRows, int cols = kCols)
      : planes(3, rows + 2 * kFlowBorder, cols + 2 * kFlowBorder) {
    const auto origin = [&](int c) { return planes.row(c, kFlowBorder) + kFlowBorder; };
    view = {origin(0), origin(1), origin(2), planes.cols(), rows, cols};
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        origin(0)[y * view.pitch + x] = code_at(static_cast<float>(x) - du, static_cast<float>(y) - dv);
    flow_kernels().extend(origin(0), view.pitch, rows, cols);
    flow_kernels().derive(origin(0), view.pitch, rows, cols, origin(1), origin(2));
  }
  Image<float> inside() const {
    Image<float> out(3, view.rows, view.cols);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < view.rows; ++y)
        std::copy_n(planes.row(c, y + kFlowBorder) + kFlowBorder, view.cols, out.row(c, y));
    return out;
  }
};

// Pictures a shift apart, their patches, and some vectors for each direction.
struct Bench {
  std::unique_ptr<GpuDevice> gpu = test::open_test_gpu();
  std::optional<FlowPasses> passes;
  Picture a{0, 0}, b{2.6f, -1.4f};
  PatchGrid grid = patch_grid(kRows, kCols, 4);

  Bench() {
    if (gpu != nullptr) passes.emplace(value_of(FlowPasses::make(*gpu)));
  }
  GpuPicture empty(int planes, int rows, int cols) {
    return value_of(GpuPicture::make(*gpu, planes, rows, cols));
  }
  GpuPicture put(const Image<float>& image) {
    GpuPicture there = empty(image.channels(), image.rows(), image.cols());
    upload(gpu->work(), image, there);
    return there;
  }
  GpuPicture put_pictures() {
    GpuPicture there = empty(kFlowLevelPlanes, kRows, kCols);
    upload(gpu->work(), a.inside(), there), upload(gpu->work(), b.inside(), there, 3);
    return there;
  }
  Image<float> get(const GpuPicture& picture) {
    Image<float> here;
    download(gpu->work(), picture, here);
    require_done(gpu->work().finish());
    return here;
  }
  FlowPicture from(int direction) const { return direction == 0 ? a.view : b.view; }
  FlowPicture to(int direction) const { return direction == 0 ? b.view : a.view; }
  FlowPlanes planes_of(Image<float>& vectors, int direction) const {
    return {vectors.plane(2 * direction), vectors.plane(2 * direction + 1)};
  }
};

// [u v there, u v back, rows, cols] about the truth.
Image<float> some_vectors(int rows, int cols, float error) {
  Image<float> vectors(kFlowVectorPlanes, rows, cols);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x)
      for (int c = 0; c < kFlowVectorPlanes; ++c) {
        const float truth = (c < 2 ? 1.f : -1.f) * (c % 2 == 0 ? 2.6f : -1.4f);
        vectors.at(c, y, x) = truth + error * std::sin(0.9f * static_cast<float>(x + 3 * y + 5 * c));
      }
  return vectors;
}

void check_alike(const Image<float>& there, const Image<float>& here, float tolerance,
                 double least_share = 1) {
  REQUIRE(there.same_shape(here));
  std::size_t alike = 0;
  float worst = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    REQUIRE(std::isfinite(there.samples()[i]));
    const float apart = std::abs(there.samples()[i] - here.samples()[i]);
    alike += apart <= tolerance ? 1 : 0, worst = std::max(worst, apart);
  }
  INFO("worst difference " << worst);
  CHECK(static_cast<double>(alike) >= least_share * static_cast<double>(here.size()));
}

}  // namespace

TEST_CASE("a scale of the flow's pictures and its derivatives are the processor's on the graphics device",
          "[gpu]") {
  Bench on;
  NEEDS_GPU(on.gpu);
  constexpr int kHalfRows = kRows / 2, kHalfCols = kCols / 2;
  const GpuPicture whole = on.put_pictures(), half = on.empty(kFlowLevelPlanes, kHalfRows, kHalfCols);
  on.passes->halve(whole, half);
  on.passes->derive(half);
  const Image<float> there = on.get(half);
  for (int d = 0; d < 2; ++d) {
    const FlowPicture whole_here = on.from(d);
    Picture here(0, 0, kHalfRows, kHalfCols);
    const auto origin = [&](int c) { return here.planes.row(c, kFlowBorder) + kFlowBorder; };
    const std::ptrdiff_t pitch = here.view.pitch;
    flow_kernels().halve(whole_here.gray, whole_here.pitch, kHalfRows, kHalfCols, origin(0), pitch);
    flow_kernels().extend(origin(0), pitch, kHalfRows, kHalfCols);
    flow_kernels().derive(origin(0), pitch, kHalfRows, kHalfCols, origin(1), origin(2));
    Image<float> part(3, kHalfRows, kHalfCols);
    std::copy_n(there.plane(3 * d), part.size(), part.plane(0));
    check_alike(part, here.inside(), 1e-4f);
  }
}

TEST_CASE("the search of patches on the graphics device is the processor's", "[gpu]") {
  Bench on;
  NEEDS_GPU(on.gpu);
  const int rows = on.grid.rows, cols = on.grid.cols;
  const bool guided = GENERATE(false, true), others = GENERATE(false, true);
  CAPTURE(guided, others);
  Image<float> patches = some_vectors(rows, cols, 2.5f), starts = some_vectors(rows, cols, 6),
               other = some_vectors(rows, cols, 0.2f);
  for (int c = 0; c < kFlowVectorPlanes; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = y % 3 == 0 ? 0 : 1; x < cols; x += 2) other.at(c, y, x) = kNowhere;
  const GpuPicture pictures = on.put_pictures(), there = on.put(patches), there_starts = on.put(starts),
                   there_others = on.put(other);
  on.passes->search({pictures, on.grid, 0}, 3, {guided, guided}, **there_starts,
                    others ? *there_others : nullptr, **there);
  const Image<float> found = on.get(there);
  for (int d = 0; d < 2; ++d) {
    PatchSearch search{on.from(d), on.to(d), on.grid, on.planes_of(patches, d), 3};
    if (guided) search.start_u = starts.plane(2 * d), search.start_v = starts.plane(2 * d + 1);
    if (others) search.other_u = other.plane(2 * d), search.other_v = other.plane(2 * d + 1);
    for (int first = 0; first < rows; first += flow_constants::kStrip)
      flow_kernels().search(search, first, std::min(first + flow_constants::kStrip, rows));
  }
  check_alike(found, patches, 5e-3f, 0.98);
}

TEST_CASE("what is found far away on the graphics device is what the processor finds", "[gpu]") {
  Bench on;
  NEEDS_GPU(on.gpu);
  on.b = Picture(17, -9);  // farther than any patch is told
  Image<float> patches = some_vectors(on.grid.rows, on.grid.cols, 1);
  const GpuPicture pictures = on.put_pictures(), there = on.put(patches),
                   far = on.empty(kFlowVectorPlanes, on.grid.rows, on.grid.cols);
  on.passes->search_far({pictures, on.grid, 0}, **there, **far);
  const Image<float> found = on.get(far);
  Image<float> expected(kFlowVectorPlanes, on.grid.rows, on.grid.cols);
  for (int d = 0; d < 2; ++d) {
    const PatchSearch search{on.from(d), on.to(d), on.grid, on.planes_of(patches, d), 3};
    flow_kernels().search_far(search, {far_reach(kCols), far_reach(kRows), on.planes_of(expected, d)}, 0,
                              on.grid.rows);
  }
  CHECK(std::ranges::count(expected.samples(), 17.f) > 20);  // some are found
  check_alike(found, expected, 0, 0.99);
}

TEST_CASE("patches are spread over the pixels on the graphics device as on the processor", "[gpu]") {
  Bench on;
  NEEDS_GPU(on.gpu);
  Image<float> patches = some_vectors(on.grid.rows, on.grid.cols, 1.5f);
  const GpuPicture pictures = on.put_pictures(), there = on.put(patches),
                   flow = on.empty(kFlowVectorPlanes, kRows, kCols);
  on.passes->spread({pictures, on.grid, 0}, **there, **flow);
  Image<float> expected(kFlowVectorPlanes, kRows, kCols), weight(1, kRows, kCols);
  for (int d = 0; d < 2; ++d) {
    const PatchSearch search{on.from(d), on.to(d), on.grid, on.planes_of(patches, d), 3};
    flow_kernels().spread(search, 0, kRows, on.planes_of(expected, d), weight.plane(0));
  }
  check_alike(on.get(flow), expected, 1e-3f);
}

TEST_CASE("the refinement of a flow on the graphics device is the processor's", "[gpu]") {
  Bench on;
  NEEDS_GPU(on.gpu);
  constexpr int kRounds = 2, kSweeps = 3;
  Image<float> flow = some_vectors(kRows, kCols, 0.8f);
  const GpuPicture pictures = on.put_pictures(), before = on.put(flow),
                   data = on.empty(kFlowDataPlanes, kRows, kCols),
                   system = on.empty(kFlowSystemPlanes, kRows, kCols);
  GpuPicture now = on.put(flow), next = on.empty(kFlowVectorPlanes, kRows, kCols);
  on.passes->linearise(pictures, **before, **data);
  for (int round = 0; round < kRounds; ++round) {
    on.passes->weigh(pictures, **data, **before, **now, **system);
    for (int i = 0; i < kSweeps; ++i) {
      on.passes->sweep(pictures, **system, **now, **next);
      std::swap(now, next);
    }
  }
  using namespace flow_constants;
  const auto floats = static_cast<std::size_t>(refinement_kernels().piece_floats(kRows, kCols));
  std::array<std::vector<float>, kRefinementPieces> room;
  for (int d = 0; d < 2; ++d) {
    FlowRefinement refinement{on.from(d), on.to(d),  on.planes_of(flow, d),
                              {},         kPictures, kLeastSlope2,
                              kSmallest,  kRounds,   kSweeps};
    for (std::size_t i = 0; i < room.size(); ++i) {
      room[i].assign(floats, 0);
      refinement.room[i] = room[i].data();
    }
    refinement_kernels().refine(refinement);
  }
  check_alike(on.get(now), flow, 2e-3f);
}
