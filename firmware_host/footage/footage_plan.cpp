#include "firmware_host/footage/footage_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/exposure_schedule.h"
#include "hal/core/sound_facts.h"
#include "hal/recording/exposure_cycle.h"
#include "hal/recording/image_sequence.h"

namespace hdrcam {
namespace {

// A factor that some files leave out has a value that nobody knows beside those of the others; one that all
// leave out is taken to stay as it is.
Result<void> check_stated(const FootageScan& seen) {
  if (!seen.silent.empty())
    return Error{
        ErrorCode::BadExposure,
        fmt::format("'{}' does not say how its frames were exposed, as the EXIF of JPEG and raw stills "
                    "does; give the cycle with --shutter 1ms,4ms,16ms, or --shutter auto to have it "
                    "estimated",
                    seen.silent)};
  const auto check = [](const StatedFactor& statement, const char* factor) -> Result<void> {
    if (statement.by.empty() || statement.not_by.empty()) return {};
    return Error{
        ErrorCode::BadExposure,
        fmt::format("'{}' does not state its {} and '{}' does, so that their exposures cannot be "
                    "compared; give the cycle with --shutter and --gain, or --shutter auto to have it "
                    "estimated",
                    statement.not_by, factor, statement.by)};
  };
  TRY(check(seen.iso, "sensitivity (ISO)"));
  return check(seen.f_number, "f-number");
}

// Time and gain of a slot are those of its first frame.
void take_stated_cycle(FootagePlan& plan) {
  const ExposureCycle cycle = find_exposure_cycle(plan.facts);
  const FrameFacts first = plan.facts.front();
  plan.cycle.resize(cycle.exposures.size());
  for (std::size_t i = plan.facts.size(); i-- > 0;) {
    FrameFacts& facts = plan.facts[i];
    facts.slot = slot_of(cycle, first, facts);
    if (facts.slot >= 0 && facts.has_exposure())
      plan.cycle[static_cast<std::size_t>(facts.slot)] = {from_seconds(facts.exposure_s), facts.gain()};
  }
}

// With lost_before of the walk: the numbers of the frames, and which of them come after a loss.
void count_missing(FootagePlan& plan) {
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < plan.facts.size(); ++i) {
    lost += static_cast<std::uint64_t>(plan.walk.lost_before[i]);
    plan.facts[i].sequence += lost;
    if (plan.walk.lost_before[i] > 0) plan.facts[i].flags |= kFrameAfterDrop;
  }
}

// Apertures are factors beside the first frame's. Stills lose nothing, but a video of motion JPEG, whose
// pictures state their exposures as stills do, has times that tell.
void take_stated(const FootageScan& seen, FootagePlan& plan) {
  const double first = seen.facts.front().digital_gain;
  for (FrameFacts& facts : plan.facts) facts.digital_gain /= first;
  plan.walk.lost_before.resize(plan.facts.size());
  for (std::size_t i = 1; i < plan.facts.size(); ++i) plan.walk.lost_before[i] = seen.steps[0][i - 1].missing;
  count_missing(plan);
  take_stated_cycle(plan);
}

// A lost frame is a longer one: also where times are counted, as those of stills are, and do not show it, or
// show only some of those that are missing.
Duration unseen_gap(const FootagePlan& plan, std::size_t at, Instant before) {
  if (at == 0 || plan.times.origin == TimeOrigin::Exif) return {};
  const double usual_s = 1 / plan.camera.framerate_hz, lost = plan.walk.lost_before[at];
  const double seen_s = to_seconds(plan.facts[at].timestamp - before);
  const double seen = std::max(0.0, std::round(seen_s / usual_s) - 1);  // frames
  return from_seconds(std::max(0.0, lost - seen) * usual_s);
}

void take_walk(FootagePlan& plan) {
  Duration later{};  // by gaps so far
  Instant before;    // as the file has it
  for (std::size_t i = 0; i < plan.facts.size(); ++i) {
    FrameFacts& facts = plan.facts[i];
    later += unseen_gap(plan, i, before);
    before = facts.timestamp;
    facts.timestamp.since_boot += later;
    const int slot = plan.walk.slots[i];
    const Exposure& exposure = plan.cycle[static_cast<std::size_t>(slot)];
    facts.exposure_s = to_seconds(exposure.time);
    facts.analogue_gain = exposure.gain, facts.digital_gain = 1;
    facts.slot = slot;
    facts.exposure_source =
        plan.origin == ExposureOrigin::Cycle ? ExposureSource::Declared : ExposureSource::Estimated;
  }
  count_missing(plan);
}

// The cycle that the user names.
Result<std::vector<Exposure>> named_cycle(const FootageRequest& request) {
  std::vector<Exposure> cycle = TRY(parse_exposures(request.shutter, request.gain));
  if (cycle.size() <= ExposureSchedule::kMaxSlots) return cycle;
  return Error{
      ErrorCode::Invalid,
      fmt::format("a cycle has 1 to {} exposures, not {}; pictures of more are imported by a {} that "
                  "states the exposure of each (docs/recording.md)",
                  int{ExposureSchedule::kMaxSlots}, cycle.size(), ImageSequence::kFile)};
}

// The way of the frames through the cycle, which is estimated where the user names none.
Result<CycleWalk> walk_of(const FootageScan& seen, FootagePlan& plan) {
  const bool estimate = plan.origin == ExposureOrigin::Estimated;
  if (estimate) plan.cycle = TRY(estimate_cycle(seen.steps));
  auto walk = find_walk(seen.steps[0], plan.cycle);
  if (!walk && estimate)  // what was estimated is no cycle that the user knows of
    return Error{ErrorCode::BadExposure,
                 "the pictures show no steady cycle of exposures; give it with --shutter"};
  return walk;
}

// As messages call it.
std::string footage_of(const std::vector<std::string>& files) {
  return files.size() == 1 ? fmt::format("'{}'", files.front())
                           : fmt::format("the footage from '{}' to '{}'", files.front(), files.back());
}

class PlannedFootage : public RecordingReader {
 public:
  PlannedFootage(std::unique_ptr<FootageReader> footage, const FootagePlan& plan)
      : footage_(std::move(footage)), plan_(plan) {}

  const CameraFacts& camera() const override { return plan_.camera; }
  std::optional<int> frame_count() const override { return static_cast<int>(plan_.facts.size()); }
  std::string file_of(std::uint64_t sequence) const override {
    if (plan_.files.size() != plan_.facts.size()) return "";  // of a video
    const auto found = std::ranges::find(plan_.facts, sequence, &FrameFacts::sequence);
    return found != plan_.facts.end() ? plan_.files[static_cast<std::size_t>(found - plan_.facts.begin())]
                                      : "";
  }
  Result<std::optional<RawFrame>> next(RawFrame room) override {
    if (next_ == plan_.facts.size()) return std::optional<RawFrame>();
    if (!TRY(footage_->next(room)))
      return Error{
          ErrorCode::Truncated,
          fmt::format("{} had {} frames, and {} when it was read again: it changed meanwhile; import it "
                      "again",
                      footage_of(plan_.files), plan_.facts.size(), next_)};
    if (room.facts.timestamp != plan_.as_read[next_])
      return Error{
          ErrorCode::Corrupt,
          fmt::format(
              "frame {} of {} is another one when it is read again: the footage changed meanwhile, or "
              "is damaged so that it decodes otherwise each time; import it again, or what ffmpeg -i "
              "makes of it",
              next_, footage_of(plan_.files))};
    return std::optional(RawFrame{plan_.facts[next_++], std::move(room.codes)});
  }

 private:
  const std::unique_ptr<FootageReader> footage_;
  const FootagePlan& plan_;
  std::size_t next_ = 0;
};

// Looks at all frames, in the order in which they are to be read. Whether it is another than that of the
// request shows at the end of the first look.
Result<FootageScan> scan_in_order(Storage& storage, const FootageRequest& request,
                                  const std::atomic<bool>& stop, FootagePlan& plan) {
  plan.files = request.files;
  auto footage = TRY(open_footage(storage, plan.files, request.framerate_hz));
  FootageScan seen = TRY(scan_footage(*footage, stop));
  const std::size_t first = first_taken(seen.taken);
  // Between neighbours the clock was set back, as at the end of summer time, and not the counter.
  plan.goes_round = request.order == FootageOrder::Numbers && first > 0 &&
                    seen.taken.size() == plan.files.size() &&
                    !is_next_number(plan.files[first - 1], plan.files[first]);
  if (!plan.goes_round) return seen;
  std::rotate(plan.files.begin(), plan.files.begin() + static_cast<std::ptrdiff_t>(first), plan.files.end());
  footage = TRY(open_footage(storage, plan.files, request.framerate_hz));
  return scan_footage(*footage, stop);
}

}  // namespace

Result<FootagePlan> plan_footage(Storage& storage, const FootageRequest& request,
                                 const std::atomic<bool>& stop) {
  FootagePlan plan;
  const bool estimate = request.shutter == kAutoShutter;
  if (!request.shutter.empty() && !estimate)  // before all frames are read
    plan.cycle = TRY(named_cycle(request));
  FootageScan seen = TRY(scan_in_order(storage, request, stop, plan));
  for (const FrameFacts& facts : seen.facts) plan.as_read.push_back(facts.timestamp);
  plan.times = TRY(take_times(seen, request.framerate_hz));
  plan.camera = seen.camera, plan.about = seen.about, plan.primaries = seen.primaries;
  plan.orientations = seen.orientations, plan.oblique = seen.oblique;
  plan.camera.turned_upright =
      !std::ranges::all_of(plan.orientations, keeps_order_of_rows, &OrientedFile::orientation);
  plan.facts = seen.facts, plan.losses = seen.losses;
  if (const auto objection = objection_to(plan.camera))
    return Error{ErrorCode::Invalid,
                 fmt::format("{} cannot be a recording: {}; give the rate of stills with --framerate",
                             footage_of(plan.files), *objection)};
  if (request.shutter.empty()) {
    TRY(check_stated(seen));
    take_stated(seen, plan);
    return plan;
  }
  plan.origin = estimate ? ExposureOrigin::Estimated : ExposureOrigin::Cycle;
  auto walk = walk_of(seen, plan);
  if (!walk && !seen.low_codes.empty())  // of nearly black pictures
    return Error{walk.error().code, fmt::format("{}; {}", walk.error().message, seen.low_codes)};
  plan.walk = TRY(std::move(walk));
  plan.copies = count_copies(seen.steps[0], plan.cycle);
  take_walk(plan);
  return plan;
}

FootagePlan plan_of_clip(CameraFacts camera, std::vector<FrameFacts> facts) {
  FootagePlan plan;
  plan.camera = std::move(camera), plan.facts = std::move(facts);
  plan.about = fmt::format("PNG, {}", ImageSequence::kFile);
  plan.walk.lost_before.resize(plan.facts.size());
  for (std::size_t i = 1; i < plan.facts.size(); ++i)
    plan.walk.lost_before[i] = static_cast<int>(std::min<std::uint64_t>(
        plan.facts[i].sequence - plan.facts[i - 1].sequence - 1, std::numeric_limits<int>::max()));
  take_stated_cycle(plan);
  if (plan.facts.front().exposure_source == ExposureSource::Estimated && !plan.cycle.empty())
    plan.origin = ExposureOrigin::Estimated;
  return plan;
}

Result<std::unique_ptr<RecordingReader>> open_planned(Storage& storage, const FootageRequest& request,
                                                      const FootagePlan& plan) {
  auto footage = TRY(open_footage(storage, plan.files, request.framerate_hz));
  return std::unique_ptr<RecordingReader>(std::make_unique<PlannedFootage>(std::move(footage), plan));
}

}  // namespace hdrcam
