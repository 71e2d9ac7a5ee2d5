#include "hal/real/buffer_slots.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

BufferSlots three() {
  BufferSlots slots("imx219");
  slots.reset(3);
  return slots;
}

void queue_one(BufferSlots& slots, std::uint64_t cookie) { slots.queue(value_of(slots.free_one()), cookie); }

TEST_CASE("a buffer is offered again only once its frame has been read") {
  BufferSlots slots = three();
  for (const std::uint64_t cookie : {70, 71, 72}) queue_one(slots, cookie);
  require_error(slots.free_one(), ErrorCode::Busy);
  CHECK(slots.lease(1) == 71);
  const auto none = slots.free_one();
  require_error(none, ErrorCode::Busy);
  CHECK(none.error().message ==
        "all 3 buffers of camera 'imx219' are queued or read; wait for a frame first");
  slots.free(1);
  CHECK(value_of(slots.free_one()) == 1);
}

TEST_CASE("a stream that stopped frees what was queued, but not what is read") {
  BufferSlots slots = three();
  for (const std::uint64_t cookie : {70, 71}) queue_one(slots, cookie);
  (void)slots.lease(0);
  CHECK(slots.any_queued());
  slots.free_queued();
  CHECK_FALSE(slots.any_queued());
  CHECK(value_of(slots.free_one()) == 1);
  require_error(slots.check_none_leased(), ErrorCode::Busy);
  slots.free(0);
  require_done(slots.check_none_leased());
}

TEST_CASE("without buffers none is free, queued or read") {
  BufferSlots slots = three();
  queue_one(slots, 70);
  slots.reset(0);
  CHECK(slots.empty());
  CHECK_FALSE(slots.any_queued());
  require_done(slots.check_none_leased());
  require_error(slots.free_one(), ErrorCode::Busy);
}

}  // namespace
}  // namespace hdrcam
