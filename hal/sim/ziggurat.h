// Standard normal numbers by the ziggurat method (Marsaglia and Tsang, Journal of Statistical Software 5(8),
// 2000; in the form of Doornik, 2005): 128 layers of equal area cover the bell, and in 79 of 80 cases a
// random position in a random layer is the result. Immutable, reentrant.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace hdrcam {

class Ziggurat {
 public:
  Ziggurat() {
    const auto density = [](double x) { return std::exp(-x * x / 2); };
    std::array<double, kLayers + 1> width{};
    width[0] = kArea / density(kTail);  // the lowest layer holds the tail
    width[1] = kTail;
    for (std::size_t i = 2; i < kLayers; ++i)
      width[i] = std::sqrt(-2 * std::log(kArea / width[i - 1] + density(width[i - 1])));
    for (std::size_t i = 0; i < kLayers; ++i)
      layers_[i] = {static_cast<float>(width[i]), static_cast<float>(width[i + 1] / width[i])};
  }

  // random: 32 random bits; more(): 64 further ones, used where those do not decide.
  template <class More>
  float normal(std::uint32_t random, More&& more) const {
    for (;; random = static_cast<std::uint32_t>(more())) {
      const std::size_t i = random % kLayers;
      const float place = static_cast<float>(static_cast<std::int32_t>(random & ~(kLayers - 1u))) * 0x1p-31f;
      const float x = place * layers_[i].width;
      if (std::abs(place) < layers_[i].sure) return x;
      if (i == 0) return std::copysign(tail(more), place);
      if (is_below(x, i, uniform(more()))) return x;
    }
  }

 private:
  static constexpr std::size_t kLayers = 128;
  static constexpr double kTail = 3.442619855899, kArea = 9.91256303526217e-3;
  struct Layer {
    float width;
    float sure;  // the part of it that lies below the bell as a whole: the width of the layer above
  };

  static float uniform(std::uint64_t bits) { return (static_cast<float>(bits >> 40) + 0.5f) * 0x1p-24f; }

  // Whether the point at x, at the share u from the layer's top to its bottom, is below the bell.
  bool is_below(float x, std::size_t i, float u) const {
    const auto over_density = [x](float width) { return std::exp((x * x - width * width) / 2); };
    const float bottom = over_density(layers_[i].width);
    const float top = over_density(layers_[i].width * layers_[i].sure);
    return top + u * (bottom - top) < 1;
  }
  // Beyond kTail (Marsaglia 1964).
  template <class More>
  static float tail(More&& more) {
    for (;;) {
      const float beyond = -std::log(uniform(more())) / static_cast<float>(kTail);
      if (-2 * std::log(uniform(more())) >= beyond * beyond) return static_cast<float>(kTail) + beyond;
    }
  }

  std::array<Layer, kLayers> layers_;
};

inline const Ziggurat kZiggurat;

}  // namespace hdrcam
