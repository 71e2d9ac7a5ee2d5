// hdrcam compare CLIP OUT: scores a folder of HDR frames against a clip with ground truth.
#include <memory>
#include <string>
#include <vector>

#include "firmware_host/command_line.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/json_flag.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/signed_text.h"
#include "firmware_host/terminal.h"
#include "hal/core/freed_pictures.h"
#include "hal/recording/image_sequence.h"
#include "render/scores/scores_json.h"

namespace hdrcam {
namespace {

struct CompareFlags {
  std::string clip, estimates, label;
  JsonFlag json;
  int skip = 1;
  KeptWork kept;
};

std::string fixed(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

std::vector<std::uint64_t> numbers_of(const std::vector<FrameScores>& frames) {
  std::vector<std::uint64_t> numbers;
  for (const FrameScores& scored : frames) numbers.push_back(scored.frame);
  return numbers;
}

// Numbers that increase, as in "1 to 7, 9".
std::string listed(const std::vector<std::uint64_t>& numbers) {
  std::string text;
  for (std::size_t begin = 0, end = 0; begin < numbers.size(); begin = end) {
    for (end = begin + 1; end < numbers.size() && numbers[end] == numbers[end - 1] + 1;) ++end;
    text += fmt::format("{}{}", begin == 0 ? "" : ", ", numbers[begin]);
    if (end - begin > 1) text += fmt::format(" to {}", numbers[end - 1]);
  }
  return text;
}

void print_table(const ClipScores& scores, const std::string& clip, const std::string& label) {
  const std::size_t clip_width = std::max<std::size_t>(clip.size(), 4);
  const std::size_t label_width = std::max<std::size_t>(label.size(), 9);
  const auto line = [&](const auto&... cells) {
    say("{:<{}}  {:<{}} {:>6} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>10} {:>7}\n", cells...);
  };
  line("", clip_width, "", label_width, "", "PSNR-mu", "moving", "worst", "PSNR-L", "PSNR-PU", "SSIM-mu",
       "log RMSE", "flicker", "background", "phase");
  line("clip", clip_width, "estimates", label_width, "frames", "dB", "dB", "dB", "dB", "dB", "0..1", "stops",
       "stops", "stops", "stops");
  const PictureScores& m = scores.mean;
  line(clip, clip_width, label, label_width, scores.frames.size(), fixed(m.psnr_mu_db, 2),
       fixed(m.psnr_mu_moving_db, 2), fixed(scores.worst.picture.psnr_mu_db, 2), fixed(m.psnr_l_db, 2),
       fixed(m.psnr_pu_db, 2), fixed(m.ssim_mu, 4), fixed(m.log_rmse_stops, 3),
       fixed(scores.flicker_stops, 4), fixed(scores.flicker_background_stops, 4),
       fixed(scores.phase_stops, 4));
}

// What the table has no column for: the gains, and what only some estimates have.
void print_details(const ClipScores& scores) {
  say("white (N) {:.3f}, gain {:.4g} {:.4g} {:.4g}, worst frame {}\n", scores.shared.white,
      scores.shared.gain[0], scores.shared.gain[1], scores.shared.gain[2], scores.worst.frame);
  say("one gain for all channels: PSNR-mu {:.2f} dB, cast {} {} {} stops\n", scores.psnr_mu_single_gain_db,
      signed_text(scores.cast_stops[0], 2), signed_text(scores.cast_stops[1], 2),
      signed_text(scores.cast_stops[2], 2));
  if (scores.depth_abs_rel) say("depth abs-rel {:.4f} (one scale for the clip)\n", *scores.depth_abs_rel);
  if (scores.flow_backward_epe_px)
    say("flow to the previous frame, end-point error {:.3f} px\n", *scores.flow_backward_epe_px);
  if (scores.flow_forward_epe_px)
    say("flow to the next frame, end-point error {:.3f} px\n", *scores.flow_forward_epe_px);
  if (scores.field_flow_epe_px)
    say("the field's flow to the previous frame, end-point error {:.3f} px, of moving objects {} px\n",
        *scores.field_flow_epe_px, fixed(scores.field_flow_moving_epe_px, 3));
  if (scores.novel_psnr_mu_db)
    say("views from other cameras (novel/), PSNR-mu {:.2f} dB\n", *scores.novel_psnr_mu_db);
}

void print_frames(const ClipScores& scores) {
  say("frames are matched by their number: {}\n", listed(numbers_of(scores.frames)));
  if (!scores.missing.empty()) say("not scored, there is no estimate: frames {}\n", listed(scores.missing));
  if (!scores.not_in_clip.empty())
    say("not scored, the clip has no such frame: estimates {}\n", listed(scores.not_in_clip));
}

void print_not_finite(const std::vector<NotFiniteEstimate>& estimates) {
  if (estimates.empty()) return;
  std::size_t samples = 0;
  for (const NotFiniteEstimate& estimate : estimates) samples += estimate.samples;
  say("not finite: {} samples, of '{}'{}; NaN is scored as 0, infinity as 60000\n", samples,
      estimates.front().path,
      estimates.size() > 1 ? fmt::format(" and {} more", estimates.size() - 1) : std::string());
}

// Not the HDR frames in its place.
Result<void> check_clip(Storage& storage, const std::string& folder) {
  const bool clip = TRY(storage.look_at(folder + "/" + ImageSequence::kFile)).kind != FileKind::Missing;
  if (clip || TRY(storage.look_at(folder)).kind != FileKind::Folder) return {};
  return Error{ErrorCode::NotFound,
               fmt::format("there is no {} in '{}'; name the clip with ground truth first, and then the "
                           "folder of the HDR frames",
                           ImageSequence::kFile, folder)};
}

Result<void> compare(Surroundings& around, const CompareFlags& flags) {
  TRY(check_clip_folder(around.storage, flags.clip));
  TRY(check_folder(around.storage, flags.estimates, "the folder with its HDR frames"));
  TRY(check_clip(around.storage, flags.clip));
  TRY(flags.kept.check(around.storage, files_of_clip(flags.clip), {flags.json.output()}));
  const FreedPicturesStay stay;
  const ClipScores scores =
      TRY(score_clip(around.storage, flags.clip, flags.estimates, {flags.skip, &around.stop}));
  const std::string clip = folder_name(flags.clip);
  const std::string label = flags.label.empty() ? folder_name(flags.estimates) : flags.label;
  if (!flags.json.stands_for_table()) {
    print_table(scores, clip, label);
    print_details(scores);
    print_frames(scores);
    print_not_finite(scores.not_finite);
  }
  return flags.json.write(around.storage, to_json(scores, clip, label));
}

}  // namespace

void add_compare(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<CompareFlags>();
  CommandLine verb =
      program.add_verb("compare", "score HDR frames against a clip with ground truth (docs/compare.md)");
  verb.add_option("CLIP", flags->clip, "folder with clip.json and gt/").required().check(names_file);
  verb.add_option("OUT", flags->estimates, "folder with the HDR frames, NNNN.exr by frame number")
      .required()
      .check(names_file);
  flags->json.add_to(verb, "the scores");
  verb.add_option("--skip", flags->skip, "frames left out at either end of the clip")
      .in_range(0, 1'000'000)
      .show_default();
  verb.add_option("--label", flags->label, "name of the estimates in the table [the folder's name]");
  flags->kept.add_without_force(verb);
  verb.on_chosen(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return compare(around, *flags); }; });
}

}  // namespace hdrcam
