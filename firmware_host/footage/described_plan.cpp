#include "firmware_host/footage/described_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/exposure_schedule.h"
#include "firmware_host/printable.h"
#include "firmware_host/signed_text.h"
#include "hal/core/counted.h"

namespace hdrcam {
namespace {

// Stops from the middle of the cycle, the reference exposure, as `info` shows them.
std::string in_stops(const Exposure& exposure, const std::vector<Exposure>& cycle) {
  double middle = 0;
  for (const Exposure& of_cycle : cycle) middle += log_product(of_cycle) / static_cast<double>(cycle.size());
  const double stops = (log_product(exposure) - middle) / std::log(2.0);
  return signed_text(stops, 2);
}

std::string described_exposures(const FootagePlan& plan) {
  const CycleWalk& walk = plan.walk;
  const std::string measured = walk.slots.empty() ? ""
                                                  : fmt::format(" ({} of {} measured)", walk.measured,
                                                                counted(plan.facts.size() - 1, "step"));
  const int slot = plan.facts.front().slot;
  const std::string phase =
      walk.ambiguous
          ? fmt::format("; the first frame is perhaps number {} of the cycle, perhaps another", slot + 1)
      : slot >= 0 ? fmt::format("; the first frame is number {} of the cycle", slot + 1)
                  : "";
  std::string stops;
  switch (plan.origin) {
    case ExposureOrigin::Cycle:
      return fmt::format("{}{}{}", describe(plan.cycle), phase, measured);
    case ExposureOrigin::Estimated:
      if (plan.cycle.size() == 1) return "estimated: all alike" + measured;
      for (const Exposure& exposure : plan.cycle)
        stops += fmt::format("{}{}", stops.empty() ? "" : " / ", in_stops(exposure, plan.cycle));
      return fmt::format("estimated, relative, {} EV{}{}", stops, phase, measured);
    case ExposureOrigin::Stated:
      break;
  }
  if (plan.cycle.empty()) return "stated by the files, no cycle";
  return fmt::format("stated by the files, a cycle of {}{}", describe(plan.cycle), phase);
}

// Whether more than a fifth of the frames of a named cycle would have been lost without a trace in their
// times, as where the camera has another cycle.
bool is_cycle_doubtful(const FootagePlan& plan) {
  if (plan.origin != ExposureOrigin::Cycle) return false;
  double untold = 0;
  for (std::size_t i = 1; i < plan.facts.size(); ++i) {
    const double passed_s = to_seconds(plan.as_read[i] - plan.as_read[i - 1]);
    const double told = plan.times.origin == TimeOrigin::Exif
                            ? 0
                            : std::max(0.0, std::round(passed_s * plan.camera.framerate_hz) - 1);
    untold += std::max(0.0, plan.walk.lost_before[i] - told);
  }
  return 4 * untold > static_cast<double>(plan.facts.size());
}

}  // namespace

std::string describe(const FootageLosses& losses) {
  const int lost = losses.lost.damaged + losses.lost.missing;
  if (losses.lost.missing > 0)
    return fmt::format("'{}' was cut: {} {} missing; the others are used", losses.path,
                       counted(lost, "frame"), lost == 1 ? "is" : "are");
  return fmt::format("'{}' is damaged: {} of its frames do not decode, or depend on such, and are left out",
                     losses.path, lost);
}

std::string describe_missing(const FootagePlan& plan) {
  constexpr int kShown = 12;  // places
  std::string places;
  std::uint64_t lost = 0;
  int losses = 0;
  for (std::size_t i = 0; i < plan.walk.lost_before.size(); ++i)
    if (const int missing = plan.walk.lost_before[i]; missing > 0) {
      lost += static_cast<std::uint64_t>(missing);
      if (++losses <= kShown) places += fmt::format("{}{}", places.empty() ? "" : ", ", i);
    }
  if (lost == 0) return "";
  const char* const doubt = is_cycle_doubtful(plan)
                                ? "; if the camera lost none, its cycle is another one than --shutter names"
                                : "";
  return fmt::format("{} {} missing, before frame {}{}{}", counted(lost, "frame"), lost == 1 ? "is" : "are",
                     places, losses > kShown ? ".." : "", doubt);
}

std::string describe_turns(const FootagePlan& plan) {
  const std::vector<OrientedFile>& first = plan.orientations;
  if (first.size() == 1 && first.front().orientation != Orientation::Upright)
    return fmt::format("the pictures are {}, as the files state", describe(first.front().orientation));
  if (first.size() < 2) return "";
  std::string each;
  for (const OrientedFile& file : first)
    each += fmt::format("{}'{}' {}", each.empty() ? "" : ", ", file.path, describe(file.orientation));
  return fmt::format("the pictures are turned as each file states; the first of each kind: {}", each);
}

std::string describe_copies(const FootagePlan& plan) {
  constexpr int kFewest = 3;  // fewer are losses of a short clip
  if (plan.copies < kFewest || 8 * static_cast<std::size_t>(plan.copies) <= plan.facts.size()) return "";
  return fmt::format(
      "{} of {} look as the one before them, as where a program raised the frame rate; if so, import the "
      "video as the camera wrote it, or take the copies out first: ffmpeg -vf mpdecimate -fps_mode vfr",
      plan.copies, counted(plan.facts.size(), "frame"));
}

std::string describe_pause(const FootagePlan& plan) {
  const auto& pause = plan.times.pause;
  if (!pause || pause->before >= plan.files.size()) return "";
  return fmt::format(
      "'{}' was taken {:.0f} s after the still before it; a recording shows one scene in one light, so if "
      "another begins there, import the stills of each by themselves",
      plan.files[pause->before], to_seconds(pause->length));
}

std::string described(const FootagePlan& plan) {
  constexpr std::size_t kShown = 12;  // frames
  const CameraFacts& camera = plan.camera;
  const bool unnamed = camera.name.empty() && !plan.files.empty();
  std::string text =
      fmt::format("{}: {}; {}x{}, {}, {}; recorded as {} of {} bits\n",
                  printable(unnamed ? plan.files.front() : camera.name), plan.about, camera.width,
                  camera.height, counted(plan.facts.size(), "frame"),
                  counted_per_second(camera.framerate_hz, "frame"), name(camera.layout), camera.bits);
  if (plan.times.origin == TimeOrigin::Exif) text += "times: as EXIF says, when each still was taken\n";
  if (!plan.times.trouble.empty())
    text += fmt::format("times: at {}, because {}\n", counted_per_second(camera.framerate_hz, "frame"),
                        plan.times.trouble);
  text += fmt::format("exposures: {}\n", described_exposures(plan));
  for (const FootageLosses& losses_of_file : plan.losses)
    text += fmt::format("warning: {}\n", describe(losses_of_file));
  if (const std::string missing = describe_missing(plan); !missing.empty()) text += missing + "\n";
  for (std::size_t i = 0; i < std::min(kShown, plan.facts.size()); ++i) {
    const FrameFacts& facts = plan.facts[i];
    const Exposure exposure{from_seconds(facts.exposure_s), facts.gain()};
    const bool relative = plan.origin == ExposureOrigin::Estimated;  // no times
    text += fmt::format("  frame {:>3} {:>9.3f} s  {}\n", i, facts.timestamp.seconds(),
                        relative ? in_stops(exposure, plan.cycle) + " EV" : describe(exposure));
  }
  if (plan.facts.size() > kShown) text += fmt::format("  .. and {} more\n", plan.facts.size() - kShown);
  return text;
}

}  // namespace hdrcam
