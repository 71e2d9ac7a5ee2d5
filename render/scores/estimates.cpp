#include "render/scores/estimates.h"

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>

#include "hal/core/folder_listing.h"
#include "hal/core/parse_number.h"
#include "render/exr.h"
#include "render/scores/linear_pictures.h"

namespace hdrcam {
namespace {

std::optional<std::uint64_t> frame_number(const std::filesystem::path& file) {
  if (file.extension() != ".exr") return std::nullopt;
  return parse_number<std::uint64_t>(file.stem().string());
}

// The two planes of a flow [dx dy, rows, cols], empty where the picture lacks one of them.
Image<float> flow_of(const ExrImage& picture, const std::string_view (&names)[2]) {
  const auto dx = picture.find(names[0]), dy = picture.find(names[1]);
  if (!dx || !dy) return {};
  Image<float> flow(2, picture.samples.rows(), picture.samples.cols());
  copy_finite(picture, *dx, flow.plane(0));
  copy_finite(picture, *dy, flow.plane(1));
  return flow;
}

}  // namespace

Result<Estimates> Estimates::open(Storage& storage, const std::string& folder,
                                  const std::function<bool(const std::string& path)>& is_scored) {
  Estimates estimates(storage);
  const FolderListing listing(folder);
  for (const std::filesystem::path& path : listing.paths()) {
    const auto number = frame_number(path);
    if (!number || (is_scored && !is_scored(path.string()))) continue;
    const auto [known, fresh] = estimates.paths_.emplace(*number, path.string());
    if (!fresh)
      return Error{ErrorCode::Invalid, fmt::format("'{}' and '{}' are both frame {}; remove one",
                                                   known->second, path.string(), *number)};
  }
  if (listing.is_missing())
    return Error{ErrorCode::NotFound, fmt::format("there is no folder '{}'", folder),
                 listing.failure().value()};
  if (listing.failure()) return listing.cannot_read();
  if (estimates.paths_.empty())
    return Error{
        ErrorCode::NotFound,
        fmt::format("'{}' holds no HDR frames; they are named by their number, as in 000007.exr", folder)};
  return estimates;
}

std::vector<std::uint64_t> Estimates::numbers() const {
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, path] : paths_) numbers.push_back(number);
  return numbers;
}

Result<Estimate> Estimates::read(std::uint64_t frame, int rows, int cols) const {
  const std::string& path = paths_.at(frame);
  const ExrImage picture = TRY(read_exr(*storage_, path));
  Estimate estimate;
  estimate.radiance = TRY(rgb_of(picture, path));
  TRY(check_size(estimate.radiance, path, rows, cols));
  if (const auto depth = picture.find(exr_channel::kDepth)) estimate.depth = plane_of(picture, *depth);
  estimate.flow_backward = flow_of(picture, exr_channel::kFlowBackward);
  estimate.flow_forward = flow_of(picture, exr_channel::kFlowForward);
  estimate.field_flow = flow_of(picture, exr_channel::kFieldFlow);
  const auto& texts = picture.attributes.texts;
  if (const auto moment = texts.find(kExrRecordedSeconds); moment != texts.end())
    estimate.recorded_s = parse_number<double>(moment->second);
  using Names = std::span<const std::string_view>;
  for (const Names layer : std::initializer_list<Names>{exr_channel::kRadiance,
                                                        {&exr_channel::kDepth, 1},
                                                        exr_channel::kFlowBackward,
                                                        exr_channel::kFlowForward,
                                                        exr_channel::kFieldFlow})
    estimate.not_finite += count_not_finite(picture, layer);
  return estimate;
}

}  // namespace hdrcam
