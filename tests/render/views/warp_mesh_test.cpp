#include "render/views/warp_mesh.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 20, kCols = 30;

// Every vertex at its own place, at one depth.
MeshVertices in_place() {
  MeshVertices vertices;
  vertices.reshape(kRows, kCols);
  for (int row = 0; row < kRows + 2; ++row)
    for (int col = 0; col < kCols + 2; ++col) {
      vertices.place.at(0, row, col) = MeshVertices::source(col, kCols);
      vertices.place.at(1, row, col) = MeshVertices::source(row, kRows);
      vertices.inverse.at(0, row, col) = 0.5f;
      vertices.rank.at(0, row, col) = 0;
      vertices.size.at(0, row, col) = 1;
    }
  return vertices;
}

// The columns from `first` on, moved to the right and nearer.
MeshVertices with_a_near_part(int first, float shift) {
  MeshVertices vertices = in_place();
  for (int row = 0; row < kRows + 2; ++row)
    for (int col = first + 1; col < kCols + 2; ++col) {
      vertices.place.at(0, row, col) += shift;
      vertices.inverse.at(0, row, col) = 1;
      vertices.rank.at(0, row, col) = 1;
    }
  return vertices;
}

MeshAnswer drawn(const MeshVertices& vertices, int threads = 1) {
  WorkerPool pool(threads);
  MeshAnswer answer;
  draw_mesh(vertices, kRows, kCols, pool, answer);
  return answer;
}

}  // namespace

TEST_CASE("a mesh that does not move shows each pixel at its own place, up to the border", "[views]") {
  const MeshAnswer answer = drawn(in_place());
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      REQUIRE(answer.inverse.at(0, y, x) == Approx(0.5f));
      REQUIRE(answer.source.at(0, y, x) == Approx(static_cast<float>(x) + 0.5f).margin(1e-4));
      REQUIRE(answer.source.at(1, y, x) == Approx(static_cast<float>(y) + 0.5f).margin(1e-4));
    }
}

TEST_CASE("where two surfaces part there is a hole, and where they meet the nearer one is seen", "[views]") {
  const MeshAnswer parted = drawn(with_a_near_part(15, 4));
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < 14; ++x) CHECK(parted.inverse.at(0, y, x) == Approx(0.5f));
    for (int x = 16; x < 18; ++x) CHECK(parted.inverse.at(0, y, x) == 0);
    for (int x = 20; x < kCols; ++x)
      CHECK(parted.source.at(0, y, x) == Approx(static_cast<float>(x) - 3.5f).margin(1e-3));
  }
  const MeshAnswer met = drawn(with_a_near_part(15, -4));
  for (int y = 0; y < kRows; ++y)
    for (int x = 12; x < 25; ++x) {
      CHECK(met.inverse.at(0, y, x) == Approx(1));
      CHECK(met.source.at(0, y, x) == Approx(static_cast<float>(x) + 4.5f).margin(1e-3));
    }
}

TEST_CASE("a mesh that is drawn twice as large is not torn", "[views]") {
  MeshVertices vertices = in_place();
  for (float& at : vertices.place.samples()) at *= 2;
  vertices.size.fill(2);
  const MeshAnswer answer = drawn(vertices);
  CHECK(std::ranges::all_of(answer.inverse.samples(), [](float inverse) { return inverse > 0; }));
  CHECK(answer.source.at(0, 7, 9) == Approx(4.75f));
}

TEST_CASE("a drawn mesh does not depend on the number of threads", "[views]") {
  const MeshAnswer one = drawn(with_a_near_part(15, 2.6f), 1), three = drawn(with_a_near_part(15, 2.6f), 3);
  CHECK(std::ranges::equal(one.inverse.samples(), three.inverse.samples()));
  CHECK(std::ranges::equal(one.rank.samples(), three.rank.samples()));
}
