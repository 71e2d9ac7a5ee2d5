// A planar picture: [channels, rows, cols], rows contiguous, 64-byte aligned. It is planar because every
// kernel of this program does the same arithmetic on each channel, which the compiler then vectorises over a
// whole plane. Pixel centres are at +0.5; x runs right, y down. Move-only: a copy is spelled clone().
// Thread-compatible: distinct objects, or distinct rows of one object, may be used from several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "hal/core/check.h"

namespace hdrcam {

// Of a picture of this size, to reckon bytes from; 0 where a side is not positive.
constexpr std::uint64_t pixel_count(int rows, int cols) {
  return static_cast<std::uint64_t>(std::max(0, rows)) * static_cast<std::uint64_t>(std::max(0, cols));
}

template <class T>
class Image {
 public:
  Image() = default;
  Image(int channels, int rows, int cols) { reshape(channels, rows, cols), fill(T{}); }
  // A picture that was moved from is empty and may be used again.
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    Image taken(std::move(other));
    swap(taken);
    return *this;
  }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;

  int channels() const { return channels_; }
  int rows() const { return rows_; }
  int cols() const { return cols_; }
  bool empty() const { return channels_ == 0; }
  std::size_t plane_size() const { return static_cast<std::size_t>(rows_) * static_cast<std::size_t>(cols_); }
  std::size_t size() const { return plane_size() * static_cast<std::size_t>(channels_); }
  template <class U>
  bool same_shape(const Image<U>& other) const {
    return channels_ == other.channels() && rows_ == other.rows() && cols_ == other.cols();
  }

  T* plane(int channel) { return data_.get() + static_cast<std::size_t>(channel) * plane_size(); }
  const T* plane(int channel) const { return data_.get() + static_cast<std::size_t>(channel) * plane_size(); }
  T* row(int channel, int y) {
    return plane(channel) + static_cast<std::size_t>(y) * static_cast<std::size_t>(cols_);
  }
  const T* row(int channel, int y) const {
    return plane(channel) + static_cast<std::size_t>(y) * static_cast<std::size_t>(cols_);
  }
  T& at(int channel, int y, int x) { return row(channel, y)[x]; }
  const T& at(int channel, int y, int x) const { return row(channel, y)[x]; }
  std::span<T> samples() { return {data_.get(), size()}; }
  std::span<const T> samples() const { return {data_.get(), size()}; }

  // Changes the shape; the content is undefined afterwards, but stays where the shape does. Allocates only
  // when the picture is larger than ever before. Throws std::bad_alloc where there is no memory for it, also
  // where no memory could be so large; the picture stays as it was.
  void reshape(int channels, int rows, int cols) {
    HDRCAM_CHECK(channels >= 0 && rows >= 0 && cols >= 0);
    const std::size_t samples = samples_of(channels, rows, cols);
    if (samples > capacity_) {
      data_.reset(static_cast<T*>(::operator new(samples * sizeof(T), kAlignment)));
      capacity_ = samples;
    }
    channels_ = channels, rows_ = rows, cols_ = cols;
  }
  void reshape_like(const Image& other) { reshape(other.channels_, other.rows_, other.cols_); }
  void fill(T value) { std::fill_n(data_.get(), size(), value); }
  void copy_from(const Image& other) {
    reshape_like(other);
    std::copy_n(other.data_.get(), size(), data_.get());
  }
  Image clone() const {
    Image copy;
    copy.copy_from(*this);
    return copy;
  }

 private:
  static constexpr std::align_val_t kAlignment{64};

  static std::size_t samples_of(int channels, int rows, int cols) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::ptrdiff_t>::max() / sizeof(T);
    const std::uint64_t pixels = pixel_count(rows, cols), planes = static_cast<std::uint64_t>(channels);
    if (planes > 0 && pixels > kMost / planes) throw std::bad_array_new_length();
    return static_cast<std::size_t>(pixels * planes);
  }

  struct Free {
    void operator()(T* p) const { ::operator delete(p, kAlignment); }
  };
  static_assert(std::is_trivially_copyable_v<T>);

  void swap(Image& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    std::swap(channels_, other.channels_), std::swap(rows_, other.rows_), std::swap(cols_, other.cols_);
  }

  std::unique_ptr<T, Free> data_;
  std::size_t capacity_ = 0;
  int channels_ = 0, rows_ = 0, cols_ = 0;
};

}  // namespace hdrcam
