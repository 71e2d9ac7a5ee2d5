#include "hal/recording/cluster_scan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "hal/recording/matroska.h"

namespace hdrcam {
namespace {

// Matroska's identifiers, with their length markers.
constexpr std::array kCluster{std::byte{0x1f}, std::byte{0x43}, std::byte{0xb6}, std::byte{0x75}};
// The type of a document, in the head of every Matroska file.
constexpr std::array kDocType{std::byte{0x42}, std::byte{0x82}, std::byte{0x88}, std::byte{'m'},
                              std::byte{'a'},  std::byte{'t'},  std::byte{'r'},  std::byte{'o'},
                              std::byte{'s'},  std::byte{'k'},  std::byte{'a'}};
constexpr std::uint64_t kOwnHead = 64;  // bytes: what lies in them is of the file itself
// Before the blocks of a cluster and, of a group, behind its block: its duration, what it refers to.
constexpr std::uint64_t kBesideBlocks[] = {0xbf, 0xe7, 0xec, 0xab, 0xa7, 0x9b, 0xfb};
constexpr std::uint64_t kSimpleBlock = 0xa3, kBlockGroup = 0xa0, kBlock = 0xa1;

std::uint64_t number(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (const std::byte byte : bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return value;
}

}  // namespace

// An identifier and a size, both with a length in leading zeros; nullopt for what cannot be one that ends by
// `end`.
Result<std::optional<ClusterScan::Element>> ClusterScan::element_at(std::uint64_t at, std::uint64_t end) {
  std::array<std::byte, 12> head{};
  const std::size_t known = TRY(file_.read_at(at, head));
  const auto length_at = [&](std::size_t i) {
    return i < known ? static_cast<std::size_t>(std::countl_zero(std::to_integer<std::uint8_t>(head[i]))) + 1
                     : std::size_t{9};
  };
  const std::size_t id_length = length_at(0);
  if (id_length > 4) return std::optional<Element>();
  const std::size_t size_length = length_at(id_length);
  if (size_length > 8 || id_length + size_length > known) return std::optional<Element>();
  Element element;
  element.id = number(std::span(head).first(id_length));
  element.size =
      number(std::span(head).subspan(id_length, size_length)) & ((std::uint64_t{1} << (7 * size_length)) - 1);
  element.content = at + id_length + size_length;
  if (element.content > end || element.size > end - element.content) return std::optional<Element>();
  return std::optional(element);
}

Result<ClusterScan::Place> ClusterScan::find_identifier() {
  constexpr std::size_t kOverlap = std::max(kCluster.size(), kDocType.size()) - 1;
  std::vector<std::byte> part(64 << 10);
  for (std::uint64_t at = at_;; at += part.size() - kOverlap) {
    const std::size_t known = TRY(file_.read_at(at, part));
    const auto end = part.begin() + static_cast<std::ptrdiff_t>(known);
    const auto found = std::search(part.begin(), end, kCluster.begin(), kCluster.end());
    const auto first =
        part.begin() + static_cast<std::ptrdiff_t>(at < kOwnHead ? std::min(kOwnHead, known) : 0);
    const auto place = [&](auto there) { return at + static_cast<std::uint64_t>(there - part.begin()); };
    const auto other = std::search(std::min(first, found), found, kDocType.begin(), kDocType.end());
    if (other != found) return Place{place(other), Mark::OtherFile};
    if (found != end) return Place{place(found), Mark::Cluster};
    if (known < part.size()) return Place{place(end), Mark::End};
  }
}

// Whether the block is one of our two tracks. A picture whose facts are missing gives way to the next one.
Result<bool> ClusterScan::take_block(const Element& block, FoundCluster& found) {
  if (block.size < matroska::kBlockHead || block.size > most_bytes_) return false;
  std::vector<std::byte> bytes(block.size);
  if (TRY(file_.read_at(block.content, bytes)) != bytes.size()) return false;
  behind_ = block.content + block.size;                      // not of its group, whose size may be damaged
  const auto track = std::to_integer<int>(bytes[0]) - 0x81;  // numbered from 1; 0x80 marks the length
  const auto content = std::span(bytes).subspan(matroska::kBlockHead);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(content.data());
  if (track == matroska::kPixelTrack) return found.picture.assign(begin, begin + content.size()), true;
  if (track == matroska::kFactsTrack) return found.facts.assign(begin, begin + content.size()), true;
  return false;
}

// Whether a cluster begins there. Its own size, in one to eight bytes, is not needed.
Result<bool> ClusterScan::enter_cluster() {
  std::array<std::byte, kCluster.size() + 1> head{};
  if (TRY(file_.read_at(behind_, head)) != head.size()) return false;
  if (!std::equal(kCluster.begin(), kCluster.end(), head.begin())) return false;
  at_ = behind_ + kCluster.size();
  const auto length =
      static_cast<std::uint64_t>(std::countl_zero(std::to_integer<std::uint8_t>(head.back()))) + 1;
  if (length > 8) return false;
  behind_ = at_ + length;
  return true;
}

// Whether what stands there can be part of a frame.
Result<bool> ClusterScan::step(std::uint64_t end, FoundCluster& found) {
  if (TRY(enter_cluster())) return true;
  std::optional<Element> element = TRY(element_at(behind_, end));
  if (!element) return false;
  if (std::ranges::find(kBesideBlocks, element->id) != std::end(kBesideBlocks))
    return behind_ = element->content + element->size, true;
  if (element->id == kBlockGroup) {
    element = TRY(element_at(element->content, element->content + element->size));
    if (!element || element->id != kBlock) return false;
  } else if (element->id != kSimpleBlock) {
    return false;
  }
  return take_block(*element, found);
}

Result<std::optional<FoundCluster>> ClusterScan::next() {
  const std::uint64_t end = TRY(file_.size());
  if (behind_ > at_) {  // not accepted
    const Place following = TRY(find_identifier());
    behind_ = std::min(behind_, following.at);
  }
  for (FoundCluster found; found.facts.empty();) {
    if (TRY(step(end, found))) {
      if (!found.facts.empty()) return std::optional(std::move(found));
      continue;
    }
    const Place identifier = TRY(find_identifier());
    if (identifier.mark != Mark::Cluster) break;
    behind_ = identifier.at;
    found = {};
  }
  return std::optional<FoundCluster>();
}

Result<std::optional<std::uint64_t>> ClusterScan::other_file() {
  Place place = TRY(find_identifier());
  for (; place.mark == Mark::Cluster; place = TRY(find_identifier())) at_ = place.at + kCluster.size();
  if (place.mark == Mark::End) return std::optional<std::uint64_t>();
  std::array<std::byte, kOwnHead> head{};  // of that file, before its type
  const std::size_t known = std::min(place.at, kOwnHead);
  const auto before = std::span(head).first(known);
  TRY(file_.read_at(place.at - known, before));
  const auto begin = std::ranges::find_end(before, matroska::kFileHead).begin();
  if (begin == before.end()) return std::optional<std::uint64_t>();
  return std::optional(place.at - static_cast<std::uint64_t>(before.end() - begin));
}

}  // namespace hdrcam
