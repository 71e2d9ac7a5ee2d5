// A list of at most N items stored in place: no allocation, copied as a value. More than N items are a bug of
// the caller. Reentrant.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <span>

#include "hal/core/check.h"

namespace hdrcam {

template <class T, std::size_t N>
class InlineList {
 public:
  InlineList() = default;
  InlineList(std::initializer_list<T> items) : InlineList(std::span<const T>(items.begin(), items.size())) {}
  explicit InlineList(std::span<const T> items) : size_(items.size()) {
    HDRCAM_CHECK_LE(items.size(), N);
    std::copy(items.begin(), items.end(), items_.begin());
  }

  void push_back(const T& item) {
    HDRCAM_CHECK_LT(size_, N);
    items_[size_++] = item;
  }
  void clear() { size_ = 0; }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }
  const T& front() const { return items_[0]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  T& operator[](std::size_t i) { return items_[i]; }
  friend bool operator==(const InlineList& a, const InlineList& b) { return std::ranges::equal(a, b); }

 private:
  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

}  // namespace hdrcam
