// The scores of a folder of HDR frames against a clip with ground truth.
//   gain      one per channel for the whole clip, the median of truth / estimate over well-exposed pixels,
//             because the response's scale is not observable; not per frame, so that flicker is not hidden
//   white     min(99.9th percentile of the clip, radiance that saturates the shortest exposure): maps to 1
//   match     a frame of the clip and the estimate of its number
//   flicker   mean |d log2 E - d log2 G| along the true motion where it is visible in both frames
//   phase     spread of the mean log2 error over the phases of the exposure cycle: 0 is no pumping
// It makes three passes over the files; between frames it holds at most one number per seven pixels of the
// clip and two pictures. Reentrant.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/result.h"
#include "hal/storage.h"
#include "render/scores/picture_scores.h"

namespace hdrcam {

struct ScoreOptions {
  int skip = 1;                             // frames left out at either end of the clip
  const std::atomic<bool>* stop = nullptr;  // when set, scoring returns Interrupted
  // Of the files in the folder and of its novel views; none: all.
  std::function<bool(const std::string& path)> is_scored = {};
};

struct FrameScores {
  std::uint64_t frame = 0;  // its number (GroundTruth::number)
  PictureScores picture;
  std::optional<double> flicker_stops;  // to the previous frame; none where that or the motion is missing
};

// An estimate with samples that are NaN or infinite. They are scored as 0 or 60000
// (render/scores/linear_pictures.h).
struct NotFiniteEstimate {
  std::string path;
  std::size_t samples = 0;
};

struct ClipScores {
  Normalisation shared;
  PictureScores mean;                   // of the frames; psnr_mu_moving_db over frames where something moves
  FrameScores worst;                    // the frame of the lowest psnr_mu
  std::optional<double> flicker_stops;  // per frame, stops
  std::optional<double> flicker_background_stops;  // on static objects only
  double phase_stops = 0;
  // A gain per channel hides a colour cast: the score with one for all, and each channel's deviation.
  double psnr_mu_single_gain_db = 0;
  std::array<double, 3> cast_stops{};              // log2 of each channel's gain over their geometric mean
  std::optional<double> depth_abs_rel;             // mean |s d - g| / g, where the estimates carry depth
  std::optional<double> flow_backward_epe_px;      // where they carry flow to the previous frame
  std::optional<double> flow_forward_epe_px;       // to the next frame, where that has an estimate
  std::optional<double> field_flow_epe_px;         // of the field's own flow to the previous frame
  std::optional<double> field_flow_moving_epe_px;  // of that, on what moves in the world
  std::optional<double> novel_psnr_mu_db;  // of the views from other cameras, where OUT/novel has them
  std::vector<FrameScores> frames;
  // Numbers of the clip's frames, except skipped ones, without an estimate.
  std::vector<std::uint64_t> missing;
  std::vector<std::uint64_t> not_in_clip;  // numbers of estimates that the clip has no frame for
  std::vector<NotFiniteEstimate> not_finite;
};

// Errors: those of GroundTruth, Estimates and read_exr; NotFound where no frame can be compared; Invalid for
// a negative skip, a film's frame that shows another moment than its number says, or where no pixel is well
// exposed in both; Interrupted.
Result<ClipScores> score_clip(Storage& storage, const std::string& clip_folder,
                              const std::string& estimates_folder, const ScoreOptions& options);

}  // namespace hdrcam
