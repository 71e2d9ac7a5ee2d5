// What can be found of a damaged recording: clusters, by their identifier, and blocks, by their head,
// wherever in the file they begin and whatever the sizes say that enclose them. Nothing is proved here: the
// checksum over picture and facts does that (facts_json.h). Thread-bound.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The two blocks of a frame.
struct FoundCluster {
  std::vector<std::uint8_t> picture;  // the packet; empty with the end record
  std::string facts;
};

// Whether a cluster begins anywhere in the file, by its identifier. Errors: those of the storage.
Result<bool> holds_cluster(StorageFile& file);

class ClusterScan {
 public:
  // from: the byte of the file where the search begins; most_bytes: of a block, more is damage; behind: the
  // byte behind the frame that was read last, 0 for none. The file outlives the scan.
  ClusterScan(StorageFile& file, std::uint64_t from, std::uint64_t most_bytes, std::uint64_t behind = 0)
      : file_(file), most_bytes_(most_bytes), at_(from), behind_(behind) {}

  // The next frame: a picture and the facts behind it, in one cluster, or, as other programs write them,
  // among others or on both sides of a cluster's head. nullopt at the end of the file, or where another one
  // was put behind it: nothing ties its frames to these. Where a frame was not accepted, or nothing can be
  // read, the search goes on at the next cluster or block, be it within what was read: sizes may be damaged,
  // and lead over other frames. Errors: those of the storage.
  Result<std::optional<FoundCluster>> next();
  // The one found last is what it seems: the search goes on behind it.
  void accept() { at_ = behind_; }
  // Where another Matroska file begins that was put behind this one; nullopt for none. Errors: as above.
  Result<std::optional<std::uint64_t>> other_file();

 private:
  struct Element {
    std::uint64_t id = 0, size = 0;
    std::uint64_t content = 0;  // where it begins
  };
  // What stands there: Frame: a cluster or a block; OtherFile: the type of a document that is not this
  // file's.
  enum class Mark { Frame, OtherFile, End };
  struct Place {
    std::uint64_t at = 0;
    Mark mark = Mark::End;
  };
  Result<Place> find_mark();
  static std::optional<Element> element_in(std::span<const std::byte> bytes, std::uint64_t at,
                                           std::uint64_t end);
  std::optional<Element> block_in(std::span<const std::byte> bytes, std::uint64_t at,
                                  std::uint64_t end) const;
  Result<bool> enter_cluster();
  Result<bool> step(std::uint64_t end, FoundCluster& found);
  Result<bool> take_block(const Element& block, FoundCluster& found);

  StorageFile& file_;
  const std::uint64_t most_bytes_;
  std::uint64_t at_;      // where the search for a mark goes on
  std::uint64_t behind_;  // the byte behind what was read last
};

}  // namespace hdrcam
