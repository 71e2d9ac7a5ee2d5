#include "firmware_host/run/record_keeping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "firmware_host/film/virtual_camera.h"
#include "firmware_host/percent_text.h"
#include "firmware_host/run/governor.h"
#include "firmware_host/run/novel_views.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/pipeline.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "render/scores/scores.h"

namespace hdrcam {
namespace {

// Shutter times are rounded to nominal ones, mostly by less.
constexpr float kNotedStops = 0.05f;

float farthest_off(const std::vector<ExposureCorrection>& exposures) {
  float most = 0;
  for (const ExposureCorrection& exposure : exposures) most = std::max(most, std::abs(exposure.stops));
  return most;
}

// What the frames told of the response and of the exposures that were stated.
void note_response(const SensorModel& sensor, RunRecord& record) {
  if (const float most = farthest_off(record.exposures); most >= kNotedStops)
    record.notes.push_back(fmt::format(
        "exposures: the stated ones are up to {:.2f} stop off, as pictures tell, or the light flickers",
        most));
  if (!sensor.response_measured())
    record.notes.emplace_back("response: no frames tell it; the mean of real cameras stands in");
  for (const int frame : sensor.relearned())
    record.notes.push_back(
        fmt::format("response: learned anew from frame {} on; the frames before showed little of it", frame));
}

// Why a sample has a share of the local contrast in its variance; of_mosaic: what a mosaic explains of it.
const char* cause_of_texture_error(float share, float of_mosaic) {
  if (of_mosaic == 0) return "the camera processes textures";
  return share > of_mosaic ? "colours of a mosaic, and what else pictures differ by" : "colours of a mosaic";
}

// What a sample is taken to err by.
void note_errors(const SensorModel& sensor, RunRecord& record) {
  const NoiseModel& noise = sensor.noise();
  record.notes.push_back(fmt::format("noise{}: full well {:.0f} electrons, read noise {:.1f} electrons",
                                     sensor.noise_measured() ? "" : " (assumed, not measured)",
                                     noise.full_well, noise.read_noise));
  if (const float share = sensor.texture_error(); share > 0)
    record.notes.push_back(fmt::format("{}: a sample's variance has {:.0f} % of the local contrast",
                                       cause_of_texture_error(share, sensor.texture_error_of_mosaic()),
                                       100 * share));
  if (const double stops = sensor.light_spread_stops(); stops > 0)
    record.notes.push_back(fmt::format(
        "light: frames of one exposure differ by {:.2f} stops (rms), as under lamps on the mains; each "
        "frame's own light counts as its exposure (--set light=steady if it does not)",
        stops));
  if (!sensor.blur_shown())
    record.notes.emplace_back(
        "motion blur: frames do not show what their exposure times state, so none is modelled (--set "
        "motion_blur=stated if they do)");
}

// What the graphics device no longer did.
void note_fallbacks(const OnlineStage& online, RunRecord& record) {
  const std::pair<const char*, std::string> reasons[] = {
      {"the state", online.fallback_reason()},
      {"the flow", online.flow_fallback_reason()},
      {"the fit of the field", online.field_fallback_reason()}};
  for (const auto& [work, reason] : reasons)
    if (!reason.empty())
      record.notes.push_back(fmt::format("the processor went on with {}: {}", work, reason));
}

}  // namespace

// A camera may run for weeks. An hour of a clip has 150 MB of records, for which only --stats and --report
// ask.
std::size_t frames_kept(const RunPlan& plan, RunPace pace) {
  const Settings::Output& output = plan.settings.output;
  const bool are_read = plan.record != nullptr || !output.path(sink_name::kStats).empty() ||
                        !output.path(sink_name::kReport).empty();
  return pace == RunPace::Clip && are_read ? std::numeric_limits<std::size_t>::max() : kFramesKept;
}

RunRecord opened_record(const RunPlan& plan, const CameraFacts& camera, RunPace pace, int threads) {
  RunRecord record;
  record.title = plan.title;
  record.command = plan.command;
  record.preset = name(plan.settings.fit.preset);
  record.seed = static_cast<std::uint64_t>(plan.settings.fit.seed);
  record.threads = threads;
  record.camera = camera.name;
  record.width = camera.width, record.height = camera.height;
  record.framerate_hz = camera.framerate_hz;
  if (pace == RunPace::Camera) {
    record.frames.resize(kFramesKept);  // so that the memory is really there, not only reserved
    record.frames.clear();
  }
  return record;
}

FrameRecord& keep(const FrameRecord& frame, std::size_t most, RunRecord& record) {
  if (record.frames.size() < most) record.frames.emplace_back();
  FrameRecord& kept = record.frames[static_cast<std::size_t>(record.emitted) % most];
  ++record.emitted;
  kept = frame;
  return kept;
}

void add_deadline(const Governor& governor, RunRecord& record) {
  record.late = governor.late();
  for (std::size_t r = 0; r < governor.ladder().size(); ++r)
    record.rungs.push_back({governor.ladder()[r].name, governor.frames_at()[r]});
}

ResponseCurves curves_of(const Response& response) {
  return {response.inverse(0), response.inverse(1), response.inverse(2)};
}

void add_findings(const Pipeline& pipeline, RunRecord& record) {
  const OnlineStage& online = pipeline.online();
  const SensorModel& sensor = online.sensor();
  record.response = curves_of(sensor.camera_response());
  record.response_prior = prior_mean_response().inverse(1);
  record.exposures = sensor.exposures().learned();
  record.light_spread_stops = sensor.light_spread_stops();
  if (online.leaves_out_given_poses())
    record.notes.emplace_back(
        "poses: the first frame states none, so they are tracked; those that later frames state have no "
        "part");
  note_response(sensor, record);
  note_errors(sensor, record);
  const BlackLevel black = sensor.camera_black_level();
  record.notes.push_back(
      fmt::format("black level: {:.1f}, {:.1f}, {:.1f} codes of 255", black[0], black[1], black[2]));
  if (const WhiteLevel& white = sensor.camera_white_level(); !white.is_largest_code())
    record.notes.push_back(
        fmt::format("white level: {:.1f}, {:.1f}, {:.1f} codes of 255", white[0], white[1], white[2]));
  if (sensor.neutral_gains())
    record.notes.push_back(fmt::format(
        "colour: white is smeared by compression or demosaicing, so R, G and B are multiplied by {:.3f}",
        fmt::join(*sensor.neutral_gains(), ", ")));
  note_fallbacks(online, record);
  if (pipeline.kept_out() > 0)
    record.notes.push_back(fmt::format("{} kept out of the fit: exposure not proved, or pixels damaged",
                                       counted(pipeline.kept_out(), "frame")));
}

void add_findings(const VirtualCamera& film, RunRecord& record) {
  record.film_pixels = film.pixels(), record.film_pixels_from_field = film.filled_pixels();
  const auto all = static_cast<double>(std::max<std::uint64_t>(1, film.pixels()));
  record.notes.push_back(fmt::format("film: {}; {} % of their pixels filled by the field",
                                     counted(film.shown(), "frame"),
                                     percent_text(static_cast<double>(film.filled_pixels()) / all)));
}

Result<void> check_not_stopped(const RunPlan& plan, const VirtualCamera& film) {
  if (plan.stop == nullptr || !*plan.stop || film.done()) return {};
  return Error{ErrorCode::Interrupted, fmt::format("stopped after {} of {} frames of the film; they are "
                                                   "complete",
                                                   film.shown(), plan.film->frames)};
}

EarlierEstimates earlier_estimates(const RunPlan& plan, Storage& storage) {
  if (plan.truth.empty()) return {EarlierFrames(storage, ""), EarlierFrames(storage, "")};
  const std::string frames = plan.settings.output.path(sink_name::kFrames);
  return {EarlierFrames(storage, frames), EarlierFrames(storage, NovelViews::files_beside(frames))};
}

Result<void> add_scores(const RunPlan& plan, const EarlierEstimates& earlier, Storage& storage,
                        RunRecord& record) {
  if (plan.truth.empty()) return {};
  const std::string folder = folder_of(plan.settings.output.path(sink_name::kFrames));
  const auto is_scored = [&](const std::string& path) {
    return !(path.starts_with(folder + "/novel/") ? earlier.novel_views : earlier.frames).remains(path);
  };
  const ClipScores scores =
      TRY(score_clip(storage, plan.truth, folder, {.stop = plan.stop, .is_scored = is_scored}));
  record.scores.push_back({"PSNR-mu", "dB", scores.mean.psnr_mu_db, true});
  record.scores.push_back({"PSNR-mu, worst frame", "dB", scores.worst.picture.psnr_mu_db, true});
  if (scores.mean.psnr_mu_moving_db)
    record.scores.push_back({"PSNR-mu, moving objects", "dB", *scores.mean.psnr_mu_moving_db, true});
  if (scores.flicker_stops)
    record.scores.push_back({"flicker", "stops per frame", *scores.flicker_stops, false});
  if (scores.novel_psnr_mu_db)
    record.scores.push_back({"PSNR-mu, novel view", "dB", *scores.novel_psnr_mu_db, true});
  record.scores.push_back({"phase pumping", "stops", scores.phase_stops, false});
  return {};
}

void close_record(std::size_t most, double wall_s, RunRecord& record) {
  if (record.frames.size() == most)  // the oldest first
    std::rotate(
        record.frames.begin(),
        record.frames.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(record.emitted) % most),
        record.frames.end());
  if (static_cast<int>(record.frames.size()) < record.emitted)
    record.notes.push_back(fmt::format("times are those of the last {} frames", record.frames.size()));
  record.dropped = record.captured - record.emitted;
  record.wall_s = wall_s;
  record.peak_memory_mib = peak_memory_mib();
}

bool is_failure(const Result<void>& outcome) {
  return !outcome && outcome.error().code != ErrorCode::Interrupted;
}

void tell_of_outputs(const RunPlan& plan, std::span<const EarlierFrames> earlier, std::string_view where) {
  for (const EarlierFrames& frames : earlier)
    if (const std::string warning = frames.warning(); !warning.empty()) remark("warning: {}\n", warning);
  if (plan.progress != nullptr) write_result_beside_frames(plan.settings.output, where);
}

}  // namespace hdrcam
