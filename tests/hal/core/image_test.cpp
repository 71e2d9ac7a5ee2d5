#include "hal/core/image.h"

#include <cstdint>
#include <limits>
#include <new>
#include <utility>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a picture that was moved from is empty and may be used again") {
  Image<float> first(3, 4, 5);
  first.at(2, 3, 4) = 7;
  Image<float> second(std::move(first));
  CHECK(second.at(2, 3, 4) == 7);
  CHECK(first.empty());
  CHECK(first.size() == 0);
  first.reshape(1, 2, 2);
  first.fill(1);
  CHECK(first.at(0, 1, 1) == 1);

  second = std::move(first);
  CHECK(second.at(0, 1, 1) == 1);
  CHECK(second.rows() == 2);
  CHECK(first.empty());
  first.copy_from(second);
  CHECK(first.same_shape(second));
}

TEST_CASE("a picture keeps its memory while it becomes smaller and larger again") {
  Image<std::uint16_t> picture(3, 8, 9);
  const std::uint16_t* const memory = picture.plane(0);
  picture.reshape(1, 2, 3);
  CHECK(picture.plane(0) == memory);
  CHECK(picture.size() == 6);
  picture.reshape(3, 8, 9);
  CHECK(picture.plane(0) == memory);
}

TEST_CASE("a picture that no memory holds is refused like one for which there is none, and stays as it was") {
  constexpr int kMost = std::numeric_limits<int>::max();
  Image<float> picture(3, 8, 9);
  picture.at(2, 7, 8) = 5;
  // of the first the samples, of the second their bytes are more than 64 bits count
  CHECK_THROWS_AS(picture.reshape(8, kMost, kMost), std::bad_alloc);
  CHECK_THROWS_AS(picture.reshape(3, kMost, kMost), std::bad_alloc);
  CHECK_THROWS_AS(Image<double>(1, kMost, 1 << 30), std::bad_alloc);
  CHECK(picture.size() == 3 * 8 * 9);
  CHECK(picture.at(2, 7, 8) == 5);
  picture.reshape(3, 8, 10);
  picture.fill(1);
  CHECK(picture.at(2, 7, 9) == 1);
}

TEST_CASE("rows of a picture lie one after the other, plane after plane, from a boundary of 64 bytes on") {
  Image<float> picture(2, 3, 5);
  CHECK(reinterpret_cast<std::uintptr_t>(picture.plane(0)) % 64 == 0);
  CHECK(picture.row(0, 1) == picture.plane(0) + 5);
  CHECK(picture.plane(1) == picture.plane(0) + 15);
  CHECK(&picture.at(1, 2, 4) == picture.samples().data() + picture.size() - 1);
}

TEST_CASE("the pixels of a picture are counted beyond what an int holds, and a side below 1 has none") {
  CHECK(pixel_count(3, 5) == 15);
  CHECK(pixel_count(1 << 20, 1 << 20) == std::uint64_t{1} << 40);
  CHECK(pixel_count(-2, 5) == 0);
}
