// How far the edges of trigger pulses were from where they were planned, in a histogram of quarter octaves
// from a microsecond on. Value type; bounded state, no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/core/instant.h"

namespace hdrcam {

class EdgeErrors {
 public:
  void add(Duration error);
  std::uint64_t count() const { return count_; }
  Duration mean() const;
  // 99 of 100 edges are no further off than this; at most 19 % more than the true figure.
  Duration p99() const;
  Duration most() const { return most_; }

 private:
  static constexpr std::size_t kBuckets = 96;  // up to 16 s
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  Duration sum_{0}, most_{0};
};

}  // namespace hdrcam
