// Pictures that a stage needs only while it works. Stages that run one after the other acquire them here and
// so share the same memory: it grows to what the largest stage needs, then nothing is allocated any more.
// Thread-bound, as the pool that owns it (worker_pool.h).
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "hal/core/image.h"

namespace hdrcam {

class ScratchPictures {
 public:
  ScratchPictures() { idle_.reserve(kUsual), sizes_.reserve(kUsual); }

  // Gives the picture this shape, in memory that is idle; its content is undefined.
  void acquire(Image<float>& picture, int channels, int rows, int cols);
  // Takes the picture's memory, whatever it is by now, and leaves it empty.
  void release(Image<float>& picture);

 private:
  // What a picture's memory holds, whoever has it; it may be more than the picture's shape needs.
  struct Size {
    const float* memory;
    std::size_t samples;
  };
  std::size_t samples_of(const Image<float>& picture) const;

  static constexpr std::size_t kUsual = 64;
  std::vector<Image<float>> idle_;
  std::vector<Size> sizes_;
};

// Pictures that are acquired for as long as this lives.
class ScratchLease {
 public:
  struct Request {
    Image<float>* picture;
    int channels;
  };

  // All of one size.
  ScratchLease(ScratchPictures& scratch, int rows, int cols, std::initializer_list<Request> requests);
  ~ScratchLease();
  ScratchLease(const ScratchLease&) = delete;
  ScratchLease& operator=(const ScratchLease&) = delete;

 private:
  static constexpr std::size_t kMost = 16;
  ScratchPictures& scratch_;
  std::array<Image<float>*, kMost> pictures_{};
  std::size_t count_ = 0;
};

}  // namespace hdrcam
