#include "firmware_host/live/frame_pool.h"

#include <vector>

#include "tests/allocation_checks.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("a frame is free again when its last holder lets go, and is handed out first") {
  FramePool pool(2);
  FrameShare first = pool.take();
  FrameShare second = pool.take();
  CHECK_FALSE(pool.take());
  const FramePool::Slot* slot = &*second;
  {
    const FrameShare also = second.another();
    second = {};
    CHECK_FALSE(pool.take());
  }
  const FrameShare again = pool.take();
  REQUIRE(again);
  CHECK(&*again == slot);
}

TEST_CASE("a frame takes its first picture without an allocation, however many were taken before") {
  constexpr int kFrames = 20;
  CameraFacts camera;
  camera.width = 48, camera.height = 32;
  for (const PixelLayout layout : {PixelLayout::Rgb, PixelLayout::BayerRggb}) {
    camera.layout = layout;
    FramePool pool(kFrames, camera);
    std::vector<FrameShare> held(kFrames);
    const std::uint64_t before = own_allocations_so_far();
    for (FrameShare& frame : held) {
      frame = pool.take();
      frame->captured.raw.codes.reshape(channels(layout), camera.height, camera.width);
    }
    CHECK_ALLOCATIONS(own_allocations_so_far() == before);
    for (const FrameShare& frame : held) CHECK(frame->captured.raw.codes.size() > 0);
    CHECK_FALSE(pool.take());
  }
}

}  // namespace
}  // namespace hdrcam
