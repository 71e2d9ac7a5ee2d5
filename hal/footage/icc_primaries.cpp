#include "hal/footage/icc_primaries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "hal/core/big_endian.h"

namespace hdrcam {
namespace {

using Xyz = std::array<double, 3>;  // relative to D50, as profiles have it

std::optional<std::uint32_t> number_at(std::span<const std::uint8_t> profile, std::size_t at) {
  if (profile.size() < 4 || at > profile.size() - 4) return std::nullopt;
  return static_cast<std::uint32_t>(big_endian(std::as_bytes(profile.subspan(at, 4))));
}

// The tag table, 7.3: behind the header of 128 bytes their number, then signature, place and size of each.
std::optional<std::size_t> place_of(std::span<const std::uint8_t> profile, std::uint32_t signature) {
  constexpr std::size_t kHeaderBytes = 128, kEntryBytes = 12;
  const auto tags = number_at(profile, kHeaderBytes);
  for (std::size_t i = 0; tags && i < *tags; ++i) {
    const std::size_t entry = kHeaderBytes + 4 + kEntryBytes * i;
    const auto here = number_at(profile, entry), place = number_at(profile, entry + 4);
    if (!here || !place) return std::nullopt;
    if (*here == signature) return *place;
  }
  return std::nullopt;
}

// XYZType, 10.27: its signature, four bytes, three numbers of 16 bits before and 16 behind the point.
std::optional<Xyz> colorant(std::span<const std::uint8_t> profile, std::uint32_t signature) {
  const auto place = place_of(profile, signature);
  if (!place) return std::nullopt;
  Xyz xyz{};
  for (std::size_t i = 0; i < xyz.size(); ++i) {
    const auto number = number_at(profile, *place + 8 + 4 * i);
    if (!number) return std::nullopt;
    xyz[i] = static_cast<std::int32_t>(*number) / 65536.0;
  }
  return xyz;
}

}  // namespace

bool states_other_primaries(std::span<const std::uint8_t> profile) {
  constexpr std::uint32_t kRed = 0x7258595a, kGreen = 0x6758595a;  // rXYZ, gXYZ
  constexpr Xyz kBt709Red{0.4360, 0.2225, 0.0139}, kBt709Green{0.3851, 0.7169, 0.0971};
  constexpr double kRounding = 0.02;  // and other adaptations to D50
  const auto differs = [](const Xyz& a, const Xyz& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most > kRounding;
  };
  const auto red = colorant(profile, kRed), green = colorant(profile, kGreen);
  return red && green && (differs(*red, kBt709Red) || differs(*green, kBt709Green));
}

}  // namespace hdrcam
