#include "online/priors/motion/flow_kernels.h"

#include <algorithm>
#include <cmath>

#include "hal/core/image.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Image<float> picture(test::Numbers& numbers, int channels, int rows, int cols, float least, float most) {
  Image<float> out(channels, rows, cols);
  const test::Row values = numbers.between(least, most, channels * rows * cols);
  std::copy(values.begin(), values.end(), out.plane(0));
  return out;
}

constexpr float kAssumed = 0.5f, kDarkest = 20, kBrightest = 235;

float confidence_of(const Image<float>& there, const Image<float>& back, const Image<float>* codes, int y,
                    int x) {
  const int rows = there.rows(), cols = there.cols();
  const float u = there.at(0, y, x), v = there.at(1, y, x);
  const float to_x = static_cast<float>(x) + u, to_y = static_cast<float>(y) + v;
  if (to_x < -0.5f || to_y < -0.5f || to_x > static_cast<float>(cols) - 0.5f ||
      to_y > static_cast<float>(rows) - 0.5f)
    return 0;
  const int at_x = std::clamp(static_cast<int>(to_x + 0.5f), 0, cols - 1),
            at_y = std::clamp(static_cast<int>(to_y + 0.5f), 0, rows - 1);
  const float off_x = u + back.at(0, at_y, at_x), off_y = v + back.at(1, at_y, at_x);
  const float agreement = std::exp(-0.5f * (off_x * off_x + off_y * off_y));
  if (codes == nullptr) return agreement;
  const auto [least, most] = std::minmax({codes->at(0, y, x), codes->at(1, y, x), codes->at(2, y, x)});
  return most <= kDarkest || least >= kBrightest ? std::max(kAssumed, agreement) : agreement;
}

}  // namespace

TEST_CASE("a flow is rated by the way there and back, and where a picture is clipped by less", "[isa]") {
  test::Numbers numbers(7);
  for (const int cols : {5, 8, 64, 83}) {
    constexpr int kRows = 9;
    const Image<float> there = picture(numbers, 2, kRows, cols, -4, 4),
                       back = picture(numbers, 2, kRows, cols, -2, 2);
    Image<float> codes = picture(numbers, 3, kRows, cols, 10, 245);
    for (int x = 0; x < cols; x += 2)
      for (int c = 0; c < 3; ++c) codes.at(c, 3, x) = 5, codes.at(c, 4, x) = 250;
    Image<float> rated(1, kRows, cols);
    int out = 0, assumed = 0;
    for (const bool seen : {false, true}) {
      flow_kernels().rate({there.plane(0), back.plane(0), kRows, cols, 0, kRows,
                           seen ? codes.plane(0) : nullptr, kDarkest, kBrightest, kAssumed, rated.plane(0)});
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < cols; ++x) {
          const float expected = confidence_of(there, back, seen ? &codes : nullptr, y, x);
          INFO(cols << " columns, pixel " << x << ", " << y);
          CHECK(rated.at(0, y, x) == Approx(expected).margin(1e-5));
          if (expected == 0) CHECK(rated.at(0, y, x) == 0);
          out += expected == 0 ? 1 : 0, assumed += expected == kAssumed ? 1 : 0;
        }
    }
    CHECK(out > 0);
    CHECK(assumed > 0);
  }
}

namespace {

// Gray and its derivatives with the border that the search wants.
struct Searched {
  Image<float> planes;
  FlowPicture view{};

  explicit Searched(const Image<float>& gray)
      : planes(3, gray.rows() + 2 * kFlowBorder, gray.cols() + 2 * kFlowBorder) {
    const auto origin = [&](int c) { return planes.row(c, kFlowBorder) + kFlowBorder; };
    const std::ptrdiff_t pitch = planes.cols();
    for (int y = 0; y < gray.rows(); ++y) std::copy_n(gray.row(0, y), gray.cols(), origin(0) + y * pitch);
    flow_kernels().extend(origin(0), pitch, gray.rows(), gray.cols());
    flow_kernels().derive(origin(0), pitch, gray.rows(), gray.cols(), origin(1), origin(2));
    view = {origin(0), origin(1), origin(2), pitch, gray.rows(), gray.cols()};
  }
};

// Root mean square of what the search moves patches by, from rest.
double moved(const Image<float>& from, const Image<float>& to) {
  constexpr int kStride = 4, kSteps = 1;
  const Searched a(from), b(to);
  const auto places = [&](int size) { return 1 + (size - kPatchSize) / kStride; };
  const PatchGrid grid{places(from.rows()), places(from.cols()), kStride};
  Image<float> patches(2, grid.rows, grid.cols);
  flow_kernels().search({a.view, b.view, grid, {patches.plane(0), patches.plane(1)}, kSteps}, 0, grid.rows);
  double sum = 0;
  for (const float v : patches.samples()) sum += static_cast<double>(v) * v;
  return std::sqrt(sum / static_cast<double>(patches.plane_size()));
}

}  // namespace

TEST_CASE("a step of the search goes as far as the texture tells against the noise", "[isa]") {
  constexpr int kRows = 64, kCols = 96;
  constexpr float kShift = 0.3f;
  test::Numbers numbers(11);
  const auto texture = [&](float shift, float noise) {
    Image<float> out = picture(numbers, 1, kRows, kCols, -noise, noise);
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        out.at(0, y, x) += 128 + 12 * std::sin(0.5f * (static_cast<float>(x) - shift)) +
                           12 * std::sin(0.4f * (static_cast<float>(y) - shift));
    return out;
  };
  const double still = moved(texture(0, 12), texture(0, 12));
  const double clean = moved(texture(0, 0.5f), texture(kShift, 0.5f));
  CAPTURE(still, clean);
  CHECK(still < 0.45);  // pixels; .56 where steps are not damped
  CHECK(clean == Approx(std::sqrt(2.0) * kShift).margin(0.03));
}
