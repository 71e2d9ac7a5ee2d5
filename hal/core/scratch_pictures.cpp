#include "hal/core/scratch_pictures.h"

#include <algorithm>
#include <utility>

namespace hdrcam {

void ScratchPictures::lend(Image<float>& picture, int channels, int rows, int cols) {
  take_back(picture);
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

void ScratchPictures::take_back(Image<float>& picture) {
  if (picture.size() > 0) idle_.push_back(std::move(picture));
  picture = {};
}

std::size_t ScratchPictures::samples_of(const Image<float>& picture) const {
  const auto found = std::ranges::find(sizes_, picture.plane(0), &Size::memory);
  return found == sizes_.end() ? picture.size() : found->samples;  // not its own: no more is known of it
}

Borrowed::Borrowed(ScratchPictures& scratch, int rows, int cols, std::initializer_list<Wish> wishes)
    : scratch_(scratch) {
  CHECK(wishes.size() <= kMost);
  for (const Wish& wish : wishes) {
    scratch_.lend(*wish.picture, wish.channels, rows, cols);
    pictures_[count_++] = wish.picture;
  }
}

Borrowed::~Borrowed() {
  while (count_ > 0) scratch_.take_back(*pictures_[--count_]);
}

}  // namespace hdrcam
