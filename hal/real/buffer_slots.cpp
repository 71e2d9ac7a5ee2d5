#include "hal/real/buffer_slots.h"

#include <algorithm>

namespace hdrcam {

Result<std::size_t> BufferSlots::free_one() const {
  const auto free = std::ranges::find(slots_, State::Free, &Slot::state);
  if (free != slots_.end()) return static_cast<std::size_t>(free - slots_.begin());
  return Error{ErrorCode::Busy,
               fmt::format("all {} buffers of camera '{}' are queued or read; wait for a frame first",
                           slots_.size(), id_)};
}

Result<void> BufferSlots::check_none_leased() const {
  if (std::ranges::find(slots_, State::Leased, &Slot::state) == slots_.end()) return {};
  return Error{
      ErrorCode::Busy,
      fmt::format("a frame of camera '{}' is still being read; give it back before configuring it", id_)};
}

bool BufferSlots::any_queued() const {
  return std::ranges::find(slots_, State::Queued, &Slot::state) != slots_.end();
}

std::uint64_t BufferSlots::lease(std::size_t index) {
  slots_[index].state = State::Leased;
  return slots_[index].cookie;
}

void BufferSlots::free_queued() {
  for (Slot& slot : slots_)
    if (slot.state == State::Queued) slot.state = State::Free;
}

}  // namespace hdrcam
