#include "render/scores/scores_json.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

nlohmann::json or_null(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

}  // namespace

std::string folder_name(const std::string& path) {
  const std::filesystem::path clean = std::filesystem::path(path).lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

std::string to_json(const ClipScores& scores, const std::string& clip, const std::string& label) {
  nlohmann::ordered_json json;
  json["clip"] = clip;
  json["label"] = label;
  json["frames"] = scores.frames.size();
  json["missing"] = scores.missing;
  json["not_in_clip"] = scores.not_in_clip;
  json["N"] = scores.shared.white;
  json["gain"] = scores.shared.gain;
  json["psnr_mu"] = scores.mean.psnr_mu_db;
  json["psnr_mu_mov"] = or_null(scores.mean.psnr_mu_moving_db);
  json["worst_psnr_mu"] = scores.worst.picture.psnr_mu_db;
  json["worst_frame"] = scores.worst.frame;
  json["psnr_l"] = scores.mean.psnr_l_db;
  json["psnr_pu"] = scores.mean.psnr_pu_db;
  json["ssim_mu"] = scores.mean.ssim_mu;
  json["log_rmse"] = scores.mean.log_rmse_stops;
  json["flicker"] = or_null(scores.flicker_stops);
  json["flick_bg"] = or_null(scores.flicker_background_stops);
  json["phase"] = scores.phase_stops;
  json["psnr_mu_single_gain"] = scores.psnr_mu_single_gain_db;
  json["cast_stops"] = scores.cast_stops;
  json["depth_abs_rel"] = or_null(scores.depth_abs_rel);
  json["flow_backward_epe_px"] = or_null(scores.flow_backward_epe_px);
  json["flow_forward_epe_px"] = or_null(scores.flow_forward_epe_px);
  json["field_flow_epe_px"] = or_null(scores.field_flow_epe_px);
  json["field_flow_moving_epe_px"] = or_null(scores.field_flow_moving_epe_px);
  json["novel_psnr_mu"] = or_null(scores.novel_psnr_mu_db);
  json["not_finite"] = nlohmann::json::array();
  for (const NotFiniteEstimate& estimate : scores.not_finite)
    json["not_finite"].push_back({{"file", estimate.path}, {"samples", estimate.samples}});
  for (const FrameScores& scored : scores.frames)
    json["per_frame"].push_back({{"frame", scored.frame},
                                 {"psnr_mu", scored.picture.psnr_mu_db},
                                 {"psnr_mu_mov", or_null(scored.picture.psnr_mu_moving_db)},
                                 {"flicker", or_null(scored.flicker_stops)},
                                 {"log_bias", scored.picture.log_bias_stops}});
  return json_text(json, 1) + "\n";
}

}  // namespace hdrcam
