// Gives a buffer back to the camera that owns it when it goes out of scope. The camera outlives its leases.
// Thread-bound like the camera.
#pragma once

#include <utility>

namespace hdrcam {

class BufferLease {
 public:
  class Owner {
   public:
    virtual void give_back(int index) = 0;

   protected:
    ~Owner() = default;
  };
  BufferLease() = default;
  BufferLease(Owner& owner, int index) : owner_(&owner), index_(index) {}
  BufferLease(BufferLease&& other) noexcept
      : owner_(std::exchange(other.owner_, nullptr)), index_(other.index_) {}
  BufferLease& operator=(BufferLease&& other) noexcept {
    std::swap(owner_, other.owner_), std::swap(index_, other.index_);
    return *this;
  }
  ~BufferLease() {
    if (owner_ != nullptr) owner_->give_back(index_);
  }

 private:
  Owner* owner_ = nullptr;
  int index_ = -1;
};

}  // namespace hdrcam
