// Where each buffer of a camera's stream is: free, queued in the driver, or leased to who reads it. The
// driver's own handles stay with the camera, by the same index. Thread-compatible: the camera's lock guards
// it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/core/result.h"

namespace hdrcam {

class BufferSlots {
 public:
  // id: of the camera, for messages.
  explicit BufferSlots(std::string id) : id_(std::move(id)) {}

  void reset(std::size_t buffers) { slots_.assign(buffers, {}); }  // all free
  bool empty() const { return slots_.empty(); }

  // The first that is free. Busy, where there is none.
  Result<std::size_t> free_one() const;
  // Busy, where a frame is still being read: its buffer cannot be taken away.
  Result<void> check_none_leased() const;

  void queue(std::size_t index, std::uint64_t cookie) { slots_[index] = {State::Queued, cookie}; }
  bool any_queued() const;
  // The driver filled it. Returns the cookie that it was queued with.
  std::uint64_t lease(std::size_t index);
  void free(std::size_t index) { slots_[index].state = State::Free; }
  // A stream that stopped dropped what was queued; leases outlast it.
  void free_queued();

 private:
  enum class State { Free, Queued, Leased };
  struct Slot {
    State state = State::Free;
    std::uint64_t cookie = 0;
  };

  std::string id_;
  std::vector<Slot> slots_;
};

}  // namespace hdrcam
