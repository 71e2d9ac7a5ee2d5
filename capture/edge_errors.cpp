#include "capture/edge_errors.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace hdrcam {
namespace {

constexpr Duration kFirstBucket = std::chrono::microseconds(1);
constexpr double kBucketsPerOctave = 4;

}  // namespace

void EdgeErrors::add(Duration error) {
  error = std::chrono::abs(error);
  ++count_, sum_ += error, most_ = std::max(most_, error);
  const double octaves = std::log2(std::max(1.0, to_seconds(error) / to_seconds(kFirstBucket)));
  ++buckets_[std::min(kBuckets - 1, static_cast<std::size_t>(octaves * kBucketsPerOctave))];
}

Duration EdgeErrors::mean() const {
  return count_ == 0 ? Duration(0) : sum_ / static_cast<Duration::rep>(count_);
}

Duration EdgeErrors::p99() const {
  const std::uint64_t wanted = count_ - count_ / 100;
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    seen += buckets_[i];
    if (seen < wanted) continue;
    const double top = to_seconds(kFirstBucket) * std::exp2(static_cast<double>(i + 1) / kBucketsPerOctave);
    return std::min(most_, Duration(static_cast<Duration::rep>(top * 1e9)));
  }
  return most_;
}

}  // namespace hdrcam
