#include "hal/footage/exif_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>

#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr int kFewestTicks = 4;                     // between two stills
constexpr std::size_t kMostDigits = 9;              // of a second: nanoseconds
constexpr int kFirstYear = 1970, kLastYear = 2261;  // whole years whose nanoseconds since 1970 fit 64 bits

// Numbers where `form` has digits, the same characters elsewhere: "0000:00:00".
template <std::size_t kCount>
std::optional<std::array<int, kCount>> numbers_in(std::string_view text, std::string_view form) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.size() < form.size()) return std::nullopt;
  std::array<int, kCount> numbers{};
  std::size_t found = 0;
  for (std::size_t i = 0; i < form.size(); ++i) {
    if (digit(form[i]) != digit(text[i]) || (!digit(form[i]) && form[i] != text[i])) return std::nullopt;
    if (!digit(form[i])) continue;
    if (i == 0 || !digit(form[i - 1])) ++found;
    numbers[found - 1] = 10 * numbers[found - 1] + (text[i] - '0');
  }
  return numbers;
}

std::optional<Duration> offset_of(std::string_view text) {
  if (text.empty() || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const auto parts = numbers_in<2>(text.substr(1), "00:00");
  if (!parts || (*parts)[0] > 14 || (*parts)[1] > 59) return std::nullopt;
  const Duration offset = std::chrono::hours((*parts)[0]) + std::chrono::minutes((*parts)[1]);
  return text[0] == '-' ? -offset : offset;
}

// When each still was taken by one clock, whatever its zone.
std::vector<Duration> on_one_clock(std::span<const std::optional<ExifTime>> stills) {
  const bool zoned =
      std::ranges::all_of(stills, [](const auto& still) { return still->from_utc.has_value(); });
  std::vector<Duration> at;
  for (const auto& still : stills) at.push_back(zoned ? still->local - *still->from_utc : still->local);
  return at;
}

bool has_time(const std::optional<ExifTime>& still) { return still.has_value(); }

}  // namespace

std::optional<ExifTime> exif_time(std::string_view date_time, std::string_view sub_second,
                                  std::string_view offset) {
  using namespace std::chrono;
  const auto parts = numbers_in<6>(date_time, "0000:00:00 00:00:00");
  if (!parts) return std::nullopt;
  const auto [y, mo, d, h, mi, s] = *parts;
  const year_month_day day{year(y), month(static_cast<unsigned>(mo)),
                           std::chrono::day(static_cast<unsigned>(d))};
  if (!day.ok() || y < kFirstYear || y > kLastYear || h > 23 || mi > 59 || s > 60) return std::nullopt;
  ExifTime time;
  time.local = sys_days(day).time_since_epoch() + hours(h) + minutes(mi) + seconds(s);
  time.tick = seconds(1);
  for (const char c : sub_second.substr(0, std::min(kMostDigits, sub_second.size()))) {
    if (c < '0' || c > '9') break;
    time.tick /= 10;
    time.local += (c - '0') * time.tick;
  }
  time.from_utc = offset_of(offset);
  return time;
}

std::size_t first_taken(std::span<const std::optional<ExifTime>> stills) {
  if (stills.empty() || !std::ranges::all_of(stills, has_time)) return 0;
  const std::vector<Duration> at = on_one_clock(stills);
  const auto earlier = std::is_sorted_until(at.begin(), at.end());
  const bool goes_round = earlier != at.end() && std::is_sorted(earlier, at.end()) && at.back() <= at.front();
  return goes_round ? static_cast<std::size_t>(earlier - at.begin()) : 0;
}

std::optional<StillPause> first_pause(std::span<const std::optional<ExifTime>> stills) {
  constexpr Duration kShortest = std::chrono::seconds(5);
  constexpr int kTimesUsual = 4;
  if (stills.size() < 2 || !std::ranges::all_of(stills, has_time)) return std::nullopt;
  std::vector<Duration> apart = on_one_clock(stills);
  std::adjacent_difference(apart.begin(), apart.end(), apart.begin());
  apart.erase(apart.begin());  // the time of the first one
  std::vector<Duration> reordered = apart;
  const Duration usual = median(reordered);
  const auto pause = std::ranges::find_if(
      apart, [&](Duration interval) { return interval >= kShortest && interval / kTimesUsual >= usual; });
  if (pause == apart.end()) return std::nullopt;
  return StillPause{static_cast<std::size_t>(pause - apart.begin()) + 1, *pause};
}

StillTimes times_of(std::span<const std::optional<ExifTime>> stills, std::span<const std::string> files) {
  StillTimes result;
  const auto with_time = std::ranges::count_if(stills, has_time);
  if (with_time == 0) return result;
  if (static_cast<std::size_t>(with_time) < stills.size()) {
    const auto without = std::ranges::find_if_not(stills, has_time) - stills.begin();
    result.trouble =
        fmt::format("EXIF of {} of the {} stills says when they were taken, that of '{}' does not", with_time,
                    stills.size(), files[static_cast<std::size_t>(without)]);
    return result;
  }
  const std::vector<Duration> at = on_one_clock(stills);
  for (std::size_t i = 1; i < stills.size(); ++i) {
    const Duration apart = at[i] - at[i - 1], tick = std::max(stills[i]->tick, stills[i - 1]->tick);
    if (apart >= kFewestTicks * tick) continue;
    result.trouble =
        apart < Duration::zero()
            ? fmt::format("'{}' was taken before '{}' by EXIF", files[i], files[i - 1])
            : fmt::format("EXIF has times in steps of {:g} s, and '{}' and '{}' are {:g} s apart by it",
                          to_seconds(tick), files[i - 1], files[i], to_seconds(apart));
    return result;
  }
  for (const Duration time : at) result.since_first.push_back(Instant{time - at.front()});
  return result;
}

}  // namespace hdrcam
