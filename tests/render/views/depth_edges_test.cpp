#include "render/views/depth_edges.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("noisy depth becomes smooth on a surface and keeps its step where the picture has an edge",
          "[views]") {
  constexpr int kRows = 40, kCols = 60, kEdge = 30;
  WorkerPool pool(2);
  Image<float> radiance(3, kRows, kCols), inverse(1, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      for (int c = 0; c < 3; ++c) radiance.at(c, y, x) = x < kEdge ? 0.1f : 1.f;
      const float noise = 0.1f * std::sin(static_cast<float>(12.9898 * x + 78.233 * y));
      inverse.at(0, y, x) = (x < kEdge ? 0.2f : 0.8f) * (1 + noise);
    }
  inverse.at(0, 20, 10) = 5;  // a single error
  DepthEdges(pool).follow(radiance, 1e-4f, inverse);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      CHECK(inverse.at(0, y, x) == Approx(x < kEdge ? 0.2f : 0.8f).epsilon(0.06));
}
