// Renders novel views of the field for scoring: for each frame whose truth has another camera (`novel_c2w` in
// gt/gt.json) and its picture (gt/novel), it writes that view as OUT/novel/NNNN.exr, which `hdrcam compare`
// scores. The truth gives the transform between the two cameras; the poses' unit of length is the median of
// true depth over the field's. Thread-bound.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "hal/core/frame.h"
#include "hal/core/worker_pool.h"
#include "hal/storage.h"
#include "online/frame_estimate.h"
#include "render/exr.h"
#include "render/scores/ground_truth.h"

namespace hdrcam {

class NovelViews {
 public:
  // The names of the views beside the HDR frames of these names.
  static std::string files_beside(const std::string& frames);
  // Whether a clip has such truth.
  static bool are_of(Storage& storage, const std::string& clip_folder);
  // camera: of the frames that are rendered; folder: of the HDR frames, which are compressed like this.
  // Storage and pool outlive the views. Errors: those of GroundTruth; SizeChanged for a clip of another size.
  static Result<NovelViews> open(Storage& storage, const std::string& clip_folder, const CameraFacts& camera,
                                 const std::string& folder, ExrCompression compression, WorkerPool& pool);

  // gains: of the HDR frames, beside which the views are scored. Does nothing for a frame without such truth
  // or without a field. Errors: those of the disk.
  Result<void> render(const FrameEstimate& estimate, const std::optional<ChannelGains>& gains);

 private:
  NovelViews(Storage& storage, GroundTruth truth, std::string folder, ExrCompression compression,
             WorkerPool& pool)
      : storage_(&storage),
        truth_(std::move(truth)),
        folder_(std::move(folder)),
        compression_(compression),
        pool_(&pool) {}

  Storage* storage_;
  GroundTruth truth_;
  std::string folder_;
  ExrCompression compression_;
  WorkerPool* pool_;
  std::map<std::uint64_t, int> frames_;  // of the truth, by sequence number
  FieldPicture own_, novel_;
};

}  // namespace hdrcam
