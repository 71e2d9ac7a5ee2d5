#include "hal/core/scratch_pictures.h"

#include <algorithm>
#include <utility>

namespace hdrcam {

void ScratchPictures::acquire(Image<float>& picture, int channels, int rows, int cols) {
  release(picture);
  const std::size_t need =
      static_cast<std::size_t>(channels) * static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  if (need == 0) return picture.reshape(channels, rows, cols);
  // Best fit, at most twice too large. Where none fits, the largest idle one that is too small grows, so that
  // no memory stays idle that is too small for every stage.
  constexpr std::size_t kMostWaste = 2;
  std::size_t best = 0, held = 0;
  for (std::size_t i = 0; i < idle_.size(); ++i) {
    const std::size_t other = samples_of(idle_[i]);
    if (other > kMostWaste * need) continue;
    if (held < need ? other > held : other >= need && other < held) best = i, held = other;
  }
  if (held > 0) {
    picture = std::move(idle_[best]);
    if (best + 1 < idle_.size()) idle_[best] = std::move(idle_.back());
    idle_.pop_back();
  }
  if (held >= need) return picture.reshape(channels, rows, cols);
  std::erase_if(sizes_, [&](const Size& size) { return size.memory == picture.plane(0); });
  picture = {};
  picture.reshape(channels, rows, cols);
  sizes_.push_back({picture.plane(0), need});
}

void ScratchPictures::release(Image<float>& picture) {
  if (picture.size() > 0) idle_.push_back(std::move(picture));
  picture = {};
}

std::size_t ScratchPictures::samples_of(const Image<float>& picture) const {
  const auto found = std::ranges::find(sizes_, picture.plane(0), &Size::memory);
  return found == sizes_.end() ? picture.size() : found->samples;  // not its own: no more is known of it
}

ScratchLease::ScratchLease(ScratchPictures& scratch, int rows, int cols,
                           std::initializer_list<Request> requests)
    : scratch_(scratch) {
  HDRCAM_CHECK(requests.size() <= kMost);
  for (const Request& request : requests) {
    scratch_.acquire(*request.picture, request.channels, rows, cols);
    pictures_[count_++] = request.picture;
  }
}

ScratchLease::~ScratchLease() {
  while (count_ > 0) scratch_.release(*pictures_[--count_]);
}

}  // namespace hdrcam
