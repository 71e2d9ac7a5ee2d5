// The greatest and the least of the newest values of a stream. No allocation. Value type.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace hdrcam {

class RecentValues {
 public:
  static constexpr std::size_t kKept = 32;  // about as many frames as the state remembers

  void add(float value) { ring_[count_++ % kKept] = value; }
  void clear() { count_ = 0; }
  // `none` where there is no value yet.
  float greatest(float none) const { return count_ > 0 ? std::ranges::max(kept()) : none; }
  float least(float none) const { return count_ > 0 ? std::ranges::min(kept()) : none; }

 private:
  std::span<const float> kept() const { return std::span(ring_).first(std::min(count_, kKept)); }

  std::array<float, kKept> ring_{};
  std::size_t count_ = 0;
};

}  // namespace hdrcam
