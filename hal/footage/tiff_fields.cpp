#include "hal/footage/tiff_fields.h"

#include <algorithm>

namespace hdrcam {
namespace {

// Of BYTE, SHORT, LONG and IFD; 0 of the others.
std::size_t bytes_of_type(std::uint32_t type) {
  constexpr std::uint32_t kByte = 1, kShort = 3, kLong = 4, kIfd = 13;
  return type == kByte ? 1 : type == kShort ? 2 : type == kLong || type == kIfd ? 4 : 0;
}

}  // namespace

TiffFields::TiffFields(std::span<const std::uint8_t> file) : file_(file), directory_(file.size()) {
  constexpr std::uint32_t kIntel = 0x4949, kMotorola = 0x4d4d, kMagic = 42;
  const auto order = number(0, 2);
  if (order != kIntel && order != kMotorola) return;
  little_endian_ = order == kIntel;
  if (const auto first = number(4, 4); first && number(2, 2) == kMagic) directory_ = *first;
}

std::optional<std::uint32_t> TiffFields::number(std::size_t at, std::size_t bytes) const {
  if (at > file_.size() || bytes > file_.size() - at) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i)
    value = value << 8 | file_[at + (little_endian_ ? bytes - 1 - i : i)];
  return value;
}

std::vector<std::uint32_t> TiffFields::values(TiffTag tag, std::size_t most) const {
  constexpr std::size_t kEntryBytes = 12, kInlineBytes = 4;
  std::vector<std::uint32_t> found;
  const auto entries = number(directory_, 2);
  for (std::size_t i = 0; entries && i < *entries; ++i) {
    const std::size_t entry = directory_ + 2 + kEntryBytes * i;
    if (number(entry, 2) != static_cast<std::uint32_t>(tag)) continue;
    const std::size_t bytes = bytes_of_type(number(entry + 2, 2).value_or(0));
    const std::size_t count = number(entry + 4, 4).value_or(0);
    if (bytes == 0) return found;
    const auto at = count * bytes <= kInlineBytes ? entry + 8 : number(entry + 8, 4).value_or(UINT32_MAX);
    for (std::size_t k = 0; k < std::min(count, most); ++k) {
      const auto value = number(at + bytes * k, bytes);
      if (!value) return found;
      found.push_back(*value);
    }
    return found;
  }
  return found;
}

std::optional<std::uint32_t> TiffFields::first_value(TiffTag tag) const {
  const std::vector<std::uint32_t> one = values(tag, 1);
  return one.empty() ? std::nullopt : std::optional(one.front());
}

}  // namespace hdrcam
