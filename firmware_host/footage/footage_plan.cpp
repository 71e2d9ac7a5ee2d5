#include "firmware_host/footage/footage_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "capture/exposure_schedule.h"
#include "firmware_host/signed_text.h"
#include "hal/core/counted.h"
#include "hal/core/median.h"
#include "hal/core/sound_facts.h"
#include "hal/recording/exposure_cycle.h"
#include "hal/recording/image_sequence.h"

namespace hdrcam {
namespace {

constexpr std::size_t kLags = ExposureSchedule::kMaxSlots;

// The first files that do and do not state a factor of the exposure; "": none.
struct Statement {
  std::string by, not_by;

  void note(bool stated, const std::string& path) {
    if (std::string& first = stated ? by : not_by; first.empty()) first = path;
  }
};

// What one look at all frames leaves: their facts, and how the pictures compare.
struct Scan {
  CameraFacts camera;
  std::string about;
  std::vector<FrameFacts> facts;
  std::vector<std::optional<ExifTime>> taken;
  bool stills = false;              // at least one
  std::vector<std::string> paths;   // of the files with frames
  std::vector<std::size_t> begins;  // the first frame of each
  std::string timed;                // the first video that says when its frames are; "": none
  StepsByLag steps;
  Statement iso, f_number;
  std::string silent;  // the first file with a frame whose exposure it does not state; "": none
  std::vector<FootageLosses> losses;
};

Result<Scan> scan(FootageReader& footage, const std::atomic<bool>& stop) {
  Scan seen;
  seen.camera = footage.camera(), seen.about = footage.about();
  seen.steps.resize(kLags);
  const auto response_of = [&](const FrameFacts& facts) {  // each raw still states its own black level
    return PhotometricResponse::before_any_fit(seen.camera.linear, facts.black_level);
  };
  Photometer photometer(response_of({}));
  std::array<PhotometricSignature, kLags + 1> recent;  // by frame number, round and round
  RawFrame frame;
  while (TRY(footage.next(frame))) {
    if (stop) return Error{ErrorCode::Interrupted, fmt::format("interrupted at frame {}", seen.facts.size())};
    const std::size_t i = seen.facts.size();
    PhotometricSignature& here = recent[i % recent.size()];
    photometer.set_response(response_of(frame.facts));
    photometer.observe(frame.codes, seen.camera.layout, seen.camera.bits, here);
    for (std::size_t lag = 1; lag <= std::min(kLags, i); ++lag)
      seen.steps[lag - 1].push_back(step_between(photometer, recent[(i - lag) % recent.size()], here));
    if (seen.paths.empty() || seen.paths.back() != footage.path())
      seen.paths.push_back(footage.path()), seen.begins.push_back(i);
    seen.facts.push_back(frame.facts);
    seen.taken.push_back(footage.taken());
    seen.stills |= footage.still();
    if (seen.timed.empty() && footage.timed()) seen.timed = footage.path();
    seen.iso.note(footage.factors().iso, footage.path());
    seen.f_number.note(footage.factors().f_number, footage.path());
    if (seen.silent.empty() && frame.facts.exposure_source != ExposureSource::Embedded)
      seen.silent = footage.path();
  }
  seen.losses = footage.losses();
  if (seen.facts.size() < 2)
    return Error{ErrorCode::TooShort, fmt::format("'{}' is a clip of {}; a clip has at least two",
                                                  seen.camera.name, counted(seen.facts.size(), "frame"))};
  return seen;
}

// Stills get the times at which they were taken, where EXIF says them well enough.
TimeOrigin take_exif_times(Scan& seen, std::string& trouble) {
  StillTimes times = times_of(seen.taken);
  trouble = std::move(times.trouble);
  if (times.since_first.empty() && trouble.empty() && seen.stills)
    trouble = "none of them says in EXIF when it was taken";
  if (times.since_first.empty()) return TimeOrigin::Files;
  for (std::size_t i = 0; i < seen.facts.size(); ++i) seen.facts[i].timestamp = times.since_first[i];
  return TimeOrigin::Exif;
}

// Frames whose times do not increase, as those of a raw stream of H.264, which has none, come at the frame
// rate; and those of Y4M, which states no more than a rate, where the user names another. rate_hz: as the
// user names it, or 0: as the file states it. Stills come at it already.
Result<void> take_regular_times(Scan& seen, double rate_hz, std::string& trouble) {
  const auto not_later = [](const FrameFacts& a, const FrameFacts& b) { return b.timestamp <= a.timestamp; };
  const bool increase = std::ranges::adjacent_find(seen.facts, not_later) == seen.facts.end();
  if (increase && (rate_hz == 0 || seen.stills)) return {};
  if (increase && !seen.timed.empty())
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' says when its frames come; leave out --framerate, which is for stills and "
                             "for videos without times",
                             seen.timed)};
  if (rate_hz > 0) seen.camera.framerate_hz = rate_hz;
  if (objection_to(seen.camera)) return {};
  for (std::size_t i = 0; i < seen.facts.size(); ++i)
    seen.facts[i].timestamp = Instant::from_seconds(static_cast<double>(i) / seen.camera.framerate_hz);
  if (!increase && trouble.empty()) trouble = "their own times do not increase";
  return {};
}

// Of stills the median. Matroska has times in milliseconds, so that a video's intervals of one frame differ:
// their mean, or what the file states where rounding may be the difference.
double usual_interval_s(std::vector<double> intervals_s, TimeOrigin times, double stated_hz) {
  constexpr double kLeast = 0.45, kMost = 1.55;  // of the median: what may be one frame
  constexpr double kRounding_s = 1e-3;           // of the first and the last time together
  std::ranges::sort(intervals_s);
  const double median_s = intervals_s[intervals_s.size() / 2];
  if (times == TimeOrigin::Exif || !(median_s > 0)) return median_s;
  const auto begin = std::ranges::lower_bound(intervals_s, kLeast * median_s);
  const auto end = std::ranges::upper_bound(intervals_s, kMost * median_s);
  const double sum_s = std::accumulate(begin, end, 0.0),
               stated_s = static_cast<double>(end - begin) / stated_hz;
  return (std::abs(sum_s - stated_s) < kRounding_s ? stated_s : sum_s) / static_cast<double>(end - begin);
}

// The usual time between the frames of a file; 0 where they are too few to tell.
double usual_interval_s(const Scan& seen, std::size_t file) {
  constexpr std::size_t kFewest = 4;  // intervals
  const std::size_t begin = seen.begins[file];
  const std::size_t end = file + 1 < seen.begins.size() ? seen.begins[file + 1] : seen.facts.size();
  if (end - begin <= kFewest) return 0;
  std::vector<double> intervals_s;
  for (std::size_t i = begin + 1; i < end; ++i)
    intervals_s.push_back(to_seconds(seen.facts[i].timestamp - seen.facts[i - 1].timestamp));
  return median(intervals_s);
}

// Between files of different rates nobody can tell a longer interval from a lost frame.
Result<void> check_one_rate(const Scan& seen) {
  constexpr double kMost = 1.5;  // from which an interval counts as two
  std::size_t first = 0;
  double first_s = 0;
  for (std::size_t file = 0; file < seen.begins.size(); ++file) {
    const double usual_s = usual_interval_s(seen, file);
    if (!(usual_s > 0)) continue;
    if (!(first_s > 0)) first = file, first_s = usual_s;
    if (usual_s < kMost * first_s && first_s < kMost * usual_s) continue;
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' has {:.4g} frames per second and '{}' {:.4g}, which do not make one clip; "
                             "import them one by one",
                             seen.paths[file], 1 / usual_s, seen.paths[first], 1 / first_s)};
  }
  return {};
}

// The usual time from a frame to the next, and what is missing where it is longer: not of stills, which are
// taken when somebody wishes.
void read_times(Scan& seen, TimeOrigin times) {
  constexpr double kMostMissing = 1e9;  // between two frames: beyond it the times are wrong
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < seen.facts.size(); ++i)
    intervals_s.push_back(to_seconds(seen.facts[i].timestamp - seen.facts[i - 1].timestamp));
  const double usual_s = usual_interval_s(intervals_s, times, seen.camera.framerate_hz);
  if (!(usual_s > 0)) return;  // no times worth the name
  seen.camera.framerate_hz = 1 / usual_s;
  if (times == TimeOrigin::Exif) return;
  for (std::size_t i = 0; i < intervals_s.size(); ++i)
    seen.steps[0][i].missing =
        static_cast<int>(std::clamp(std::round(intervals_s[i] / usual_s) - 1, 0.0, kMostMissing));
}

// A factor that some files leave out has a value that nobody knows beside those of the others; one that all
// leave out is taken to stay as it is.
Result<void> check_stated(const Scan& seen) {
  if (!seen.silent.empty())
    return Error{
        ErrorCode::BadExposure,
        fmt::format("'{}' does not say how its frames were exposed, as the EXIF of JPEG and raw stills "
                    "does; give the cycle with --shutter 1ms,4ms,16ms, or --shutter auto to have it "
                    "estimated",
                    seen.silent)};
  const auto check = [](const Statement& statement, const char* factor) -> Result<void> {
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

// Apertures are factors beside the first frame's.
void take_stated(const Scan& seen, FootagePlan& plan) {
  const double first = seen.facts.front().digital_gain;
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < plan.facts.size(); ++i) {
    plan.facts[i].digital_gain /= first;
    if (i > 0) lost += static_cast<std::uint64_t>(seen.steps[0][i - 1].missing);
    plan.facts[i].sequence += lost;
  }
  take_stated_cycle(plan);
}

// A lost frame is a longer one: also where times are counted, as those of stills are, and do not show it.
Duration unseen_gap(const FootagePlan& plan, std::size_t at, Instant before) {
  const double usual_s = 1 / plan.camera.framerate_hz, lost = plan.walk.lost_before[at];
  if (at == 0 || plan.times == TimeOrigin::Exif) return {};
  const double seen_s = to_seconds(plan.facts[at].timestamp - before);
  return seen_s > (lost + 0.5) * usual_s ? Duration{} : from_seconds(lost * usual_s);
}

void take_walk(FootagePlan& plan) {
  std::uint64_t lost = 0;
  Duration later{};  // by gaps so far
  Instant before;    // as the file has it
  for (std::size_t i = 0; i < plan.facts.size(); ++i) {
    FrameFacts& facts = plan.facts[i];
    later += unseen_gap(plan, i, before);
    before = facts.timestamp;
    facts.timestamp.since_boot += later;
    const int slot = plan.walk.slots[i];
    const Exposure& exposure = plan.cycle[static_cast<std::size_t>(slot)];
    lost += static_cast<std::uint64_t>(plan.walk.lost_before[i]);
    facts.sequence += lost;
    if (plan.walk.lost_before[i] > 0) facts.flags |= kFrameAfterDrop;
    facts.exposure_s = to_seconds(exposure.time);
    facts.analogue_gain = exposure.gain, facts.digital_gain = 1;
    facts.slot = slot;
    facts.exposure_source =
        plan.origin == ExposureOrigin::Cycle ? ExposureSource::Declared : ExposureSource::Estimated;
  }
}

class PlannedFootage : public RecordingReader {
 public:
  PlannedFootage(std::unique_ptr<FootageReader> footage, const FootagePlan& plan)
      : footage_(std::move(footage)), plan_(plan) {}

  const CameraFacts& camera() const override { return plan_.camera; }
  std::optional<int> frame_count() const override { return static_cast<int>(plan_.facts.size()); }
  Result<std::optional<RawFrame>> next(RawFrame room) override {
    if (next_ == plan_.facts.size()) return std::optional<RawFrame>();
    if (!TRY(footage_->next(room)))
      return Error{
          ErrorCode::Truncated,
          fmt::format("'{}' had {} frames, and {} when it was read again: it changed meanwhile; import "
                      "it again",
                      plan_.camera.name, plan_.facts.size(), next_)};
    if (room.facts.timestamp != plan_.as_read[next_])
      return Error{
          ErrorCode::Corrupt,
          fmt::format(
              "frame {} of '{}' is another one when it is read again: the footage changed meanwhile, or "
              "is damaged so that it decodes otherwise each time; import it again, or what ffmpeg -i "
              "makes of it",
              next_, plan_.camera.name)};
    return std::optional(RawFrame{plan_.facts[next_++], std::move(room.codes)});
  }

 private:
  const std::unique_ptr<FootageReader> footage_;
  const FootagePlan& plan_;
  std::size_t next_ = 0;
};

// Stops from the middle of the cycle, the reference exposure, as `info` shows them.
std::string in_stops(const Exposure& exposure, const std::vector<Exposure>& cycle) {
  double middle = 0;
  for (const Exposure& of_cycle : cycle) middle += log_product(of_cycle) / static_cast<double>(cycle.size());
  const double stops = (log_product(exposure) - middle) / std::log(2.0);
  return signed_text(stops, 2);
}

std::string described_exposures(const FootagePlan& plan) {
  const CycleWalk& walk = plan.walk;
  const std::string measured =
      walk.slots.empty() ? ""
                         : fmt::format(" ({} of {} steps measured)", walk.measured, plan.facts.size() - 1);
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

}  // namespace

Result<FootagePlan> plan_footage(Storage& storage, const FootageRequest& request,
                                 const std::atomic<bool>& stop) {
  const auto footage = TRY(open_footage(storage, request.files, request.framerate_hz));
  Scan seen = TRY(scan(*footage, stop));
  FootagePlan plan;
  for (const FrameFacts& facts : seen.facts) plan.as_read.push_back(facts.timestamp);
  if (request.framerate_hz == 0) plan.times = take_exif_times(seen, plan.time_trouble);
  if (plan.times == TimeOrigin::Files) TRY(take_regular_times(seen, request.framerate_hz, plan.time_trouble));
  if (plan.times == TimeOrigin::Files) TRY(check_one_rate(seen));
  read_times(seen, plan.times);
  plan.camera = seen.camera, plan.about = seen.about, plan.facts = seen.facts, plan.losses = seen.losses;
  if (const auto objection = objection_to(plan.camera))
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' cannot be a recording: {}; give the rate of stills with "
                             "--framerate",
                             plan.camera.name, *objection)};
  if (request.shutter.empty()) {
    TRY(check_stated(seen));
    take_stated(seen, plan);
    return plan;
  }
  const bool estimate = request.shutter == kAutoShutter;
  plan.origin = estimate ? ExposureOrigin::Estimated : ExposureOrigin::Cycle;
  plan.cycle =
      estimate ? TRY(estimate_cycle(seen.steps)) : TRY(parse_exposures(request.shutter, request.gain));
  auto walk = find_walk(seen.steps[0], plan.cycle);
  if (!walk && estimate)  // what was estimated is no cycle that the user knows of
    return Error{ErrorCode::BadExposure,
                 "the pictures show no steady cycle of exposures; give it with --shutter"};
  plan.walk = TRY(std::move(walk));
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
  auto footage = TRY(open_footage(storage, request.files, request.framerate_hz));
  return std::unique_ptr<RecordingReader>(std::make_unique<PlannedFootage>(std::move(footage), plan));
}

std::string describe(const FootageLosses& losses) {
  const int lost = losses.lost.damaged + losses.lost.missing;
  if (losses.lost.missing > 0)
    return fmt::format("'{}' was cut: {} of its frames are missing; the others are used", losses.path, lost);
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
  return fmt::format("{} {} missing, before frame {}{}", counted(lost, "frame"), lost == 1 ? "is" : "are",
                     places, losses > kShown ? ".." : "");
}

std::string described(const FootagePlan& plan) {
  constexpr std::size_t kShown = 12;  // frames
  const CameraFacts& camera = plan.camera;
  std::string text =
      fmt::format("{}: {}; {}x{}, {}, {:.4g} frames per second; recorded as {} of {} bits\n", camera.name,
                  plan.about, camera.width, camera.height, counted(plan.facts.size(), "frame"),
                  camera.framerate_hz, name(camera.layout), camera.bits);
  if (plan.times == TimeOrigin::Exif) text += "times: as EXIF says, when each still was taken\n";
  if (!plan.time_trouble.empty())
    text +=
        fmt::format("times: at {:.4g} frames per second, for {}\n", camera.framerate_hz, plan.time_trouble);
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
