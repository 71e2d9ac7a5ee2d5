#include "render/hdr_frame.h"

#include <algorithm>
#include <span>

namespace hdrcam {

std::array<float, kProvenances> provenance_shares(const Image<std::uint8_t>& provenance) {
  constexpr std::size_t kTurns = 4;  // neighbours are mostly alike: one count would wait for itself
  std::array<std::array<std::size_t, 256>, kTurns> pixels{};
  const std::span<const std::uint8_t> from = provenance.samples();
  for (std::size_t i = 0; i < from.size(); ++i) ++pixels[i % kTurns][from[i]];
  std::array<float, kProvenances> shares{};
  const auto all = static_cast<double>(std::max<std::size_t>(1, from.size()));
  for (std::size_t i = 0; i < kProvenances; ++i) {
    std::size_t count = 0;
    for (const auto& turn : pixels) count += turn[i];
    shares[i] = static_cast<float>(static_cast<double>(count) / all);
  }
  return shares;
}

}  // namespace hdrcam
