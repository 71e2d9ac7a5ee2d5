#include "hal/core/scratch_pictures.h"

#include "tests/allocation_checks.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("stages that run one after the other share the memory of the largest one") {
  ScratchPictures scratch;
  Image<float> a, b, c;
  const float* first = nullptr;
  {
    const ScratchLease room(scratch, 20, 30, {{&a, 3}, {&b, 1}});
    CHECK(a.channels() == 3);
    CHECK(b.rows() == 20);
    CHECK(b.cols() == 30);
    first = a.plane(0);
  }
  CHECK(a.empty());
  const ScratchLease room(scratch, 20, 30, {{&c, 2}});
  CHECK(c.channels() == 2);
  CHECK(c.plane(0) == first);  // the smallest that is large enough
}

TEST_CASE("pictures that are borrowed at the same time do not share memory") {
  ScratchPictures scratch;
  Image<float> a, b;
  const ScratchLease outer(scratch, 8, 8, {{&a, 1}});
  a.fill(1);
  const ScratchLease inner(scratch, 8, 8, {{&b, 1}});
  b.fill(2);
  for (const float value : a.samples()) REQUIRE(value == 1);
}

TEST_CASE("memory that changed its owner while it was borrowed goes round with the others") {
  ScratchPictures scratch;
  Image<float> kept(3, 10, 10), next;
  const float* before = kept.plane(0);
  {
    const ScratchLease room(scratch, 10, 10, {{&next, 3}});
    next.fill(7);
    std::swap(kept, next);
  }
  for (const float value : kept.samples()) REQUIRE(value == 7);
  Image<float> later;
  const ScratchLease room(scratch, 10, 10, {{&later, 3}});
  CHECK(later.plane(0) == before);
}

TEST_CASE("what was borrowed once is borrowed again without allocating") {
  ScratchPictures scratch;
  Image<float> a, b, c;
  const auto frame = [&] {
    { const ScratchLease large(scratch, 40, 40, {{&a, 1}, {&b, 3}}); }
    const ScratchLease small(scratch, 20, 40, {{&a, 3}, {&b, 2}, {&c, 1}});
  };
  for (int i = 0; i < 4; ++i) frame();
  const std::uint64_t before = own_allocations_so_far();
  for (int i = 0; i < 20; ++i) frame();
  CHECK_ALLOCATIONS(own_allocations_so_far() == before);
}
