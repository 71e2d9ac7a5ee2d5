// A folder of HDR frames to be scored: files named by the frame's number with any number of digits and `.exr`
// (000007.exr, 0007.exr). Thread-bound; returns fresh images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// One estimated frame; a layer that the file does not have is an empty image.
struct Estimate {
  Image<float> radiance;             // [rgb, rows, cols] finite
  Image<float> depth;                // [1, rows, cols] camera z, any unit
  Image<float> flow_backward;        // [dx dy, rows, cols] pixels to the previous frame
  Image<float> flow_forward;         // [dx dy, rows, cols] pixels to the next frame
  Image<float> field_flow;           // [dx dy, rows, cols] the field's, pixels to the previous frame
  std::optional<double> recorded_s;  // of a film's frame: the moment that it shows (HdrFrame)
  std::size_t not_finite = 0;        // samples of these layers in the file that were NaN or infinite
};

class Estimates {
 public:
  // Errors: NotFound where the folder or any numbered .exr in it is missing; Invalid where two files have the
  // same number. is_scored: of its files; none: all.
  static Result<Estimates> open(Storage& storage, const std::string& folder,
                                const std::function<bool(const std::string& path)>& is_scored = {});

  bool contains(std::uint64_t frame) const { return paths_.contains(frame); }
  std::vector<std::uint64_t> numbers() const;  // of all its frames, in their order
  const std::string& path(std::uint64_t frame) const { return paths_.at(frame); }
  // Errors: those of read_exr and rgb_of; SizeChanged.
  Result<Estimate> read(std::uint64_t frame, int rows, int cols) const;

 private:
  explicit Estimates(Storage& storage) : storage_(&storage) {}

  Storage* storage_;
  std::map<std::uint64_t, std::string> paths_;  // by frame
};

}  // namespace hdrcam
