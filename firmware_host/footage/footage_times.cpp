#include "firmware_host/footage/footage_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hal/core/counted.h"
#include "hal/core/median.h"
#include "hal/core/sound_facts.h"

namespace hdrcam {
namespace {

// The file of each frame.
std::vector<std::string> files_of_frames(const FootageScan& seen) {
  std::vector<std::string> files;
  for (std::size_t file = 0; file < seen.paths.size(); ++file)
    files.resize(file + 1 < seen.begins.size() ? seen.begins[file + 1] : seen.facts.size(), seen.paths[file]);
  return files;
}

// Stills get the times at which they were taken, where EXIF says them well enough.
TimeOrigin take_exif_times(FootageScan& seen, std::string& trouble) {
  StillTimes times = times_of(seen.taken, files_of_frames(seen));
  trouble = std::move(times.trouble);
  if (times.since_first.empty() && trouble.empty() && seen.stills)
    trouble = "none of them states in EXIF when it was taken";
  if (times.since_first.empty()) return TimeOrigin::Files;
  for (std::size_t i = 0; i < seen.facts.size(); ++i) seen.facts[i].timestamp = times.since_first[i];
  return TimeOrigin::Exif;
}

// Frames whose times do not increase, as those of a raw stream of H.264, which has none, come at the frame
// rate; and those of Y4M, which states no more than a rate, where the user names another. rate_hz: as the
// user names it, or 0: as the file states it. Stills come at it already.
Result<void> take_regular_times(FootageScan& seen, double rate_hz, std::string& trouble) {
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

std::vector<double> intervals_between(std::span<const FrameFacts> frames) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < frames.size(); ++i)
    intervals_s.push_back(to_seconds(frames[i].timestamp - frames[i - 1].timestamp));
  return intervals_s;
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
double usual_interval_s(const FootageScan& seen, std::size_t file) {
  constexpr std::size_t kFewest = 4;  // intervals
  const std::size_t begin = seen.begins[file];
  const std::size_t end = file + 1 < seen.begins.size() ? seen.begins[file + 1] : seen.facts.size();
  if (end - begin <= kFewest) return 0;
  std::vector<double> intervals_s = intervals_between(std::span(seen.facts).subspan(begin, end - begin));
  return median(intervals_s);
}

// Between files of different rates nobody can tell a longer interval from a lost frame.
Result<void> check_one_rate(const FootageScan& seen) {
  constexpr double kMost = 1.5;  // from which an interval counts as two
  std::size_t first = 0;
  double first_s = 0;
  for (std::size_t file = 0; file < seen.begins.size(); ++file) {
    const double usual_s = usual_interval_s(seen, file);
    if (!(usual_s > 0)) continue;
    if (!(first_s > 0)) first = file, first_s = usual_s;
    if (usual_s < kMost * first_s && first_s < kMost * usual_s) continue;
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' has {} and '{}' {:.4g}, which do not make one clip; import them one by one",
                    seen.paths[file], counted_per_second(1 / usual_s, "frame"), seen.paths[first],
                    1 / first_s)};
  }
  return {};
}

// Whether every frame comes when the stated rate says, and none is missing: at 670 frames per second and more
// a millisecond less or more is half an interval, which tells neither.
bool are_of_stated_rate(const std::vector<double>& intervals_s, double stated_hz) {
  constexpr double kRounding_s = 1e-3;  // of the first time and another one together
  double late_s = 0;
  return std::ranges::all_of(intervals_s, [&](double interval_s) {
    late_s += interval_s - 1 / stated_hz;
    return std::abs(late_s) < kRounding_s;
  });
}

// The usual time from a frame to the next, and what is missing where it is longer: not of stills, which are
// taken when somebody wishes.
void read_times(FootageScan& seen, TimeOrigin times) {
  constexpr double kMostMissing = 1e9;  // between two frames: beyond it the times are wrong
  const std::vector<double> intervals_s = intervals_between(seen.facts);
  if (times == TimeOrigin::Files && are_of_stated_rate(intervals_s, seen.camera.framerate_hz)) return;
  const double usual_s = usual_interval_s(intervals_s, times, seen.camera.framerate_hz);
  if (!(usual_s > 0)) return;  // no times worth the name
  seen.camera.framerate_hz = 1 / usual_s;
  if (times == TimeOrigin::Exif) return;
  for (std::size_t i = 0; i < intervals_s.size(); ++i)
    seen.steps[0][i].missing =
        static_cast<int>(std::clamp(std::round(intervals_s[i] / usual_s) - 1, 0.0, kMostMissing));
}

}  // namespace

Result<FootageTimes> take_times(FootageScan& seen, double rate_hz) {
  FootageTimes times;
  times.pause = first_pause(seen.taken);
  if (rate_hz == 0) times.origin = take_exif_times(seen, times.trouble);
  if (times.origin == TimeOrigin::Files) TRY(take_regular_times(seen, rate_hz, times.trouble));
  if (times.origin == TimeOrigin::Files) TRY(check_one_rate(seen));
  read_times(seen, times.origin);
  return times;
}

}  // namespace hdrcam
