#include "hal/recording/cluster_scan.h"

#include <algorithm>
#include <array>
#include <span>

#include "hal/core/big_endian.h"
#include "hal/recording/matroska.h"

namespace hdrcam {
namespace {

// Identifiers with their length markers, of Matroska (RFC 9559, section 5.1) and of EBML around it (RFC
// 8794).
constexpr std::array kCluster{std::byte{0x1f}, std::byte{0x43}, std::byte{0xb6}, std::byte{0x75}};
// The type of a document, in the head of every Matroska file.
constexpr std::array kDocType{std::byte{0x42}, std::byte{0x82}, std::byte{0x88}, std::byte{'m'},
                              std::byte{'a'},  std::byte{'t'},  std::byte{'r'},  std::byte{'o'},
                              std::byte{'s'},  std::byte{'k'},  std::byte{'a'}};
constexpr std::uint64_t kOwnHead = 64;  // bytes: what lies in them is of the file itself
// What may stand before the blocks of a cluster: CRC-32, Timestamp, Void, PrevSize, Position; and in a group
// behind its block: BlockDuration, ReferenceBlock.
constexpr std::uint64_t kBesideBlocks[] = {0xbf, 0xe7, 0xec, 0xab, 0xa7, 0x9b, 0xfb};
constexpr std::uint64_t kSimpleBlock = 0xa3, kBlockGroup = 0xa0, kBlock = 0xa1;
// A block begins with its track, numbered from 1; 0x80 marks the number's length.
constexpr std::byte kTrackOfPixels{0x81 + matroska::kPixelTrack}, kTrackOfFacts{0x81 + matroska::kFactsTrack};
constexpr std::size_t kMostHead = 19;  // bytes: identifier and size of a group and of its block, the track
constexpr std::size_t kPartBytes = 64 << 10;

}  // namespace

Result<bool> holds_cluster(StorageFile& file) {
  std::vector<std::byte> part(kPartBytes);
  for (std::uint64_t at = 0;; at += part.size() - (kCluster.size() - 1)) {
    const std::size_t known = TRY(file.read_at(at, part));
    const auto bytes = std::span<const std::byte>(part).first(known);
    if (std::search(bytes.begin(), bytes.end(), kCluster.begin(), kCluster.end()) != bytes.end()) return true;
    if (known < part.size()) return false;
  }
}

// An identifier and a size, both with a length in leading zeros; nullopt for what cannot be one that ends by
// `end`. bytes: those from `at` on.
std::optional<ClusterScan::Element> ClusterScan::element_in(std::span<const std::byte> bytes,
                                                            std::uint64_t at, std::uint64_t end) {
  if (bytes.empty()) return {};
  const std::size_t id_length = matroska::length_by(bytes.front());
  if (id_length > 4 || id_length > bytes.size()) return {};
  const auto size = matroska::size_in(bytes.subspan(id_length));
  if (!size) return {};
  const Element element{big_endian(bytes.first(id_length)), size->bytes, at + id_length + size->length};
  if (element.content > end || element.size > end - element.content) return {};
  return element;
}

// The block that begins there, or in the group that does; nullopt for what cannot be one of our tracks.
// bytes: those from `at` on, kMostHead of them where the file has as many.
std::optional<ClusterScan::Element> ClusterScan::block_in(std::span<const std::byte> bytes, std::uint64_t at,
                                                          std::uint64_t end) const {
  if (bytes.empty() || (bytes[0] != std::byte{kSimpleBlock} && bytes[0] != std::byte{kBlockGroup})) return {};
  std::optional<Element> block = element_in(bytes, at, end);
  const bool in_group = block && block->id == kBlockGroup;
  if (in_group)
    block = element_in(bytes.subspan(block->content - at), block->content, block->content + block->size);
  if (!block || block->id != (in_group ? kBlock : kSimpleBlock)) return {};
  if (block->size < matroska::kBlockHead || block->size > most_bytes_) return {};
  const std::uint64_t track = block->content - at;
  if (track >= bytes.size() || (bytes[track] != kTrackOfPixels && bytes[track] != kTrackOfFacts)) return {};
  return block;
}

Result<ClusterScan::Place> ClusterScan::find_mark() {
  constexpr std::size_t kOverlap = std::max({kCluster.size(), kDocType.size(), kMostHead}) - 1;
  const std::uint64_t file_end = TRY(file_.size());
  std::vector<std::byte> part(kPartBytes);
  for (std::uint64_t at = at_;; at += part.size() - kOverlap) {
    const std::size_t known = TRY(file_.read_at(at, part));
    const auto bytes = std::span<const std::byte>(part).first(known);
    const auto cluster = std::search(bytes.begin(), bytes.end(), kCluster.begin(), kCluster.end());
    const auto first =
        bytes.begin() + static_cast<std::ptrdiff_t>(at < kOwnHead ? std::min(kOwnHead, known) : 0);
    const auto other = std::search(std::min(first, cluster), cluster, kDocType.begin(), kDocType.end());
    const auto offset = [&](auto there) { return static_cast<std::size_t>(there - bytes.begin()); };
    for (std::size_t i = 0; i < offset(other); ++i)
      if (block_in(bytes.subspan(i), at + i, file_end)) return Place{at + i, Mark::Frame};
    if (other != cluster) return Place{at + offset(other), Mark::OtherFile};
    if (cluster != bytes.end()) return Place{at + offset(cluster), Mark::Frame};
    if (known < part.size()) return Place{at + known, Mark::End};
  }
}

// Whether the block is there as a whole and can be part of the frame. Of two pictures the first has lost its
// facts, or a wrong size, that leads over other frames: they are searched for within it.
Result<bool> ClusterScan::take_block(const Element& block, FoundCluster& found) {
  std::vector<std::byte> bytes(block.size);
  if (TRY(file_.read_at(block.content, bytes)) != bytes.size()) return false;
  const auto content = std::span(bytes).subspan(matroska::kBlockHead);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(content.data());
  const bool is_picture = bytes[0] == kTrackOfPixels, is_second = !found.picture.empty();
  if (is_picture && is_second) return false;
  if (is_picture) found.picture.assign(begin, begin + content.size());
  if (!is_picture) found.facts.assign(begin, begin + content.size());
  if (!is_second) at_ = behind_ + 1;
  behind_ = block.content + block.size;  // not of its group, whose size may be damaged
  return true;
}

// Whether a cluster begins there. Its own size, in one to eight bytes, is not needed.
Result<bool> ClusterScan::enter_cluster() {
  std::array<std::byte, kCluster.size() + 1> head{};
  if (TRY(file_.read_at(behind_, head)) != head.size()) return false;
  if (!std::equal(kCluster.begin(), kCluster.end(), head.begin())) return false;
  const std::size_t length = matroska::length_by(head.back());
  if (length > 8) return false;
  behind_ += kCluster.size() + length;
  return true;
}

// Whether what stands there can be part of a frame.
Result<bool> ClusterScan::step(std::uint64_t end, FoundCluster& found) {
  if (TRY(enter_cluster())) return true;
  std::array<std::byte, kMostHead> head{};
  const std::size_t known = TRY(file_.read_at(behind_, head));
  const auto bytes = std::span<const std::byte>(head).first(known);
  if (const auto block = block_in(bytes, behind_, end)) return take_block(*block, found);
  const auto element = element_in(bytes, behind_, end);
  if (!element || std::ranges::find(kBesideBlocks, element->id) == std::end(kBesideBlocks)) return false;
  return behind_ = element->content + element->size, true;
}

Result<std::optional<FoundCluster>> ClusterScan::next() {
  const std::uint64_t end = TRY(file_.size());
  if (behind_ > at_) {  // not accepted
    const Place following = TRY(find_mark());
    behind_ = std::min(behind_, following.at);
  }
  for (FoundCluster found; found.facts.empty();) {
    if (TRY(step(end, found))) {
      if (!found.facts.empty()) return std::optional(std::move(found));
      continue;
    }
    const Place place = TRY(find_mark());
    if (place.mark != Mark::Frame) break;
    at_ = place.at + 1;
    behind_ = place.at;
    found = {};
  }
  return std::optional<FoundCluster>();
}

Result<std::optional<std::uint64_t>> ClusterScan::other_file() {
  Place place = TRY(find_mark());
  for (; place.mark == Mark::Frame; place = TRY(find_mark())) at_ = place.at + 1;
  if (place.mark == Mark::End) return std::optional<std::uint64_t>();
  std::array<std::byte, kOwnHead> head{};  // of that file, before its type
  const std::size_t known = std::min(place.at, kOwnHead);
  const auto before = std::span(head).first(known);
  TRY(file_.read_at(place.at - known, before));
  // not std::ranges::find_end: clang 14 does not compile it with the C++ library of GCC 12
  const auto begin =
      std::find_end(before.begin(), before.end(), matroska::kFileHead.begin(), matroska::kFileHead.end());
  if (begin == before.end()) return std::optional<std::uint64_t>();
  return std::optional(place.at - static_cast<std::uint64_t>(before.end() - begin));
}

}  // namespace hdrcam
