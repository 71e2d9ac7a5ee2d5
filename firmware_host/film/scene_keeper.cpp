#include "firmware_host/film/scene_keeper.h"

#include <utility>

#include "firmware_host/film/steady_path.h"
#include "firmware_host/version.h"
#include "hal/core/image.h"

namespace hdrcam {

Result<void> SceneKeeper::name_file(Storage& storage, const std::string& path) {
  making_.emplace(TRY(FileInMaking::beside_or_through(storage, path)));
  return {};
}

void SceneKeeper::take(const HdrFrame& frame, const FrameEstimate& estimate) {
  Kept next;
  if (kept_.size() == most_) {
    const Keyframe& oldest = kept_.front().key;
    if (oldest.frame.pose) head_.path.push_back({oldest.time_s, oldest.T_world_camera, oldest.world});
    next.key = std::move(kept_.front().key);  // for its memory
    kept_.pop_front();
  }
  take_keyframe(frame, estimate, next.key);
  next.field = estimate.field.snapshot();
  kept_.push_back(std::move(next));
  copy(estimate.frame, head_.input);
  std::erase_if(head_.path, [reach_s = kept_.front().key.time_s - SteadyPath::kReach_s](
                                const PathPose& pose) { return pose.time_s < reach_s; });
}

Result<void> SceneKeeper::save(const CameraFacts& camera, const Response& response) {
  if (kept_.empty()) return {};
  head_.program = fmt::format("hdrcam {}", kVersion);
  head_.camera = camera;
  const SnapshotHold field = kept_.back().field;
  head_.has_field = static_cast<bool>(field);
  std::vector<SnapshotHold> fields;
  for (Kept& kept : kept_) {
    head_.frames.push_back(std::move(kept.key));
    fields.push_back(std::move(kept.field));
  }
  kept_.clear();
  SceneWriter writer = TRY(SceneWriter::create(*std::move(making_), head_, response));
  for (std::size_t i = 0; i < fields.size(); ++i) {
    Keyframe& key = head_.frames[i];
    maker_.complete(fields[i], i > 0 ? &head_.frames[i - 1] : nullptr, key);
    TRY(writer.add(key));
    if (i > 0) head_.frames[i - 1] = {};
  }
  return writer.finish(head_.input, field);
}

std::uint64_t kept_scene_bytes(int width, int height, int frames, int field_step_px) {
  constexpr std::uint64_t kPicture = 25;  // of a pixel and frame, with the state's motion
  constexpr std::uint64_t kInput = 12;    // of a pixel, of the newest frame
  constexpr std::uint64_t kSaving = 120;  // of a pixel: two whole keyframes and the search of their motion
  constexpr std::uint64_t kField = 100;   // of a pixel of the field and frame that a snapshot keeps
  constexpr std::uint64_t kNetworks = 8 << 20;  // of a snapshot
  const auto count = static_cast<std::uint64_t>(frames), step = static_cast<std::uint64_t>(field_step_px);
  return pixel_count(height, width) *
             (kPicture * count + kInput + kSaving + kField * 2 * count / (step * step)) +
         kNetworks * count;
}

}  // namespace hdrcam
