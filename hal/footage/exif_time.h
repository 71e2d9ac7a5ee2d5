// When stills were taken, as EXIF says it (Exif 2.32, 4.6.5: DateTimeOriginal, SubSecTimeOriginal,
// OffsetTimeOriginal), and whether that is good enough to be the times of a clip. Plain values; reentrant.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/instant.h"

namespace hdrcam {

struct ExifTime {
  Duration local{};                  // since 1970 by the camera's clock, in whatever zone it is
  std::optional<Duration> from_utc;  // of that clock
  Duration tick{};                   // what the text resolves: 1 s, 100 ms for one digit of SubSecTime ..
};

// "2026:11:22 17:03:04", "25", "+01:00"; the last two may be empty. nullopt where the first is no time from
// 1970 to 2261, as the blanks, zeros or nines of a camera without a clock.
std::optional<ExifTime> exif_time(std::string_view date_time, std::string_view sub_second,
                                  std::string_view offset);

// Where stills that go round begin, as those of a camera whose counter began anew: the still from which on
// their times do not decrease, with the first ones behind the last. 0 where they are in order, where no such
// place puts them in order, and where not all state their time.
std::size_t first_taken(std::span<const std::optional<ExifTime>> stills);

// A still that was taken long after the one before it: another scene may begin there.
struct StillPause {
  std::size_t before;  // its place
  Duration length;
};
// The first one: five seconds or more, and four times what is usual between the stills. nullopt where there
// is none, and where not all state their time.
std::optional<StillPause> first_pause(std::span<const std::optional<ExifTime>> stills);

// The times of stills in their order: from the first one on, empty where they cannot be used, and then why,
// as a clause; no clause where no still has any.
struct StillTimes {
  std::vector<Instant> since_first;
  std::string trouble;
};
// Usable: every still has one, they increase, and none is closer to the next than four ticks, so that
// rounding moves no interval by more than a quarter. Zones count where every still states its own. files: of
// each still, to name it.
StillTimes times_of(std::span<const std::optional<ExifTime>> stills, std::span<const std::string> files);

}  // namespace hdrcam
