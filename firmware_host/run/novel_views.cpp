#include "firmware_host/run/novel_views.h"

#include <fmt/format.h>

#include <vector>

#include "firmware_host/sinks/output_folder.h"
#include "hal/core/geometry.h"
#include "render/scores/motion_scores.h"
#include "render/scores/order_statistics.h"
#include "render/white_balance.h"

namespace hdrcam {

std::string NovelViews::files_beside(const std::string& frames) {
  return folder_of(frames) + "/novel/%06d.exr";
}

bool NovelViews::are_of(Storage& storage, const std::string& clip_folder) {
  return is_there(storage, clip_folder + "/gt/novel");
}

Result<NovelViews> NovelViews::open(Storage& storage, const std::string& clip_folder,
                                    const CameraFacts& camera, const std::string& folder,
                                    ExrCompression compression, WorkerPool& pool) {
  NovelViews views(storage, TRY(GroundTruth::open(storage, clip_folder)), folder + "/novel", compression,
                   pool);
  const GroundTruth& truth = views.truth_;
  if (truth.cols() != camera.width || truth.rows() != camera.height)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("the clip '{}' has {}x{} pixels and the recording {}x{}; give --truth the clip "
                             "that was recorded",
                             clip_folder, truth.cols(), truth.rows(), camera.width, camera.height)};
  for (int frame = 0; frame < views.truth_.frames(); ++frame)
    if (views.truth_.novel_camera(frame)) views.frames_.emplace(views.truth_.number(frame), frame);
  return views;
}

Result<void> NovelViews::render(const FrameEstimate& estimate, const std::optional<ChannelGains>& gains) {
  const auto found = frames_.find(estimate.frame.facts.sequence);
  if (found == frames_.end() || !estimate.field) return {};
  const int frame = found->second;
  if (TRY(truth_.novel_radiance(frame)).empty()) return {};
  const Image<float> depth = TRY(truth_.depth(frame));
  if (depth.empty()) return {};

  estimate.field->look(estimate.view, *pool_, own_);
  std::vector<float> metres_per_unit;  // of the field's depth
  collect_depth_ratios(depth, own_.depth, metres_per_unit);
  if (metres_per_unit.empty()) return {};

  const PosePair& cameras = *truth_.novel_camera(frame);
  RigidTransform T_own_novel =
      transform_of(cameras.T_world_own).inverse() * transform_of(cameras.T_world_novel);
  T_own_novel.t *=
      static_cast<double>(estimate.depth_unit) / static_cast<double>(numpy_median(metres_per_unit));
  SceneView view = estimate.view;
  view.T_world_camera = view.T_world_camera * T_own_novel;
  estimate.field->look(view, *pool_, novel_);

  if (gains) apply_white_balance(*gains, novel_.radiance);
  ExrPicture picture;
  picture.rows = novel_.radiance.rows(), picture.cols = novel_.radiance.cols();
  for (int c = 0; c < 3; ++c)
    picture.channels.push_back({std::string(exr_channel::kRadiance[c]),
                                {novel_.radiance.plane(c), novel_.radiance.plane_size()},
                                ExrSample::Half});
  picture.compression = compression_;
  const auto bytes = TRY(encode_exr(picture));
  TRY(storage_->make_directories(folder_));
  return write_whole(*storage_, fmt::format("{}/{:06d}.exr", folder_, found->first), bytes,
                     Durability::WrittenBack);
}

}  // namespace hdrcam
