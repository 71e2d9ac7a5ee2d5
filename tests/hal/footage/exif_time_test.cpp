#include "hal/footage/exif_time.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using namespace std::chrono_literals;

namespace {

std::vector<std::optional<ExifTime>> stills(const std::vector<std::array<const char*, 3>>& texts) {
  std::vector<std::optional<ExifTime>> times;
  for (const auto& [date_time, sub_second, offset] : texts)
    times.push_back(exif_time(date_time, sub_second, offset));
  return times;
}

// Of files a.jpg, b.jpg ..
StillTimes times_of(const std::vector<std::optional<ExifTime>>& taken) {
  std::vector<std::string> files;
  for (std::size_t i = 0; i < taken.size(); ++i) files.push_back(std::string(1, "abcd"[i]) + ".jpg");
  return hdrcam::times_of(taken, files);
}

}  // namespace

TEST_CASE("a time of EXIF has the resolution of its digits, and its zone where it states one") {
  const auto whole = exif_time("1970:01:02 00:00:03", "", "");
  REQUIRE(whole);
  CHECK(whole->local == 24h + 3s);
  CHECK(whole->tick == 1s);
  CHECK_FALSE(whole->from_utc);
  const auto fine = exif_time("2026:02:28 23:59:59", "042  ", "-05:30");
  REQUIRE(fine);
  CHECK(fine->local % 1s == 42ms);
  CHECK(fine->tick == 1ms);
  CHECK(fine->from_utc == -(5h + 30min));
  CHECK(exif_time("2026:02:28 23:59:59", "1234567891", "")->tick == 1ns);
}

TEST_CASE("a clock that was never set gives no time, nor does a text that states none") {
  for (const char* text :
       {"", "    :  :     :  :  ", "0000:00:00 00:00:00", "2026:02:29 12:00:00", "2026:13:01 12:00:00",
        "2026:01:01 24:00:00", "2026-01-01 12:00:00", "2026:01:01T12:00:00", "2026:01:01 12:00"}) {
    INFO(text);
    CHECK_FALSE(exif_time(text, "5", "+00:00"));
  }
  for (const char* beyond_64_bits : {"2263:01:01 00:00:00", "9999:12:31 23:59:59"}) {
    INFO(beyond_64_bits);
    CHECK_FALSE(exif_time(beyond_64_bits, "", ""));
  }
  const auto last = exif_time("2261:12:31 23:59:59", "", "-14:00");
  REQUIRE(last);
  CHECK(last->local - *last->from_utc > last->local);
  for (const char* offset : {"", "   :  ", "01:00", "+1:00", "+25:00", "+01:60"}) {
    INFO(offset);
    CHECK_FALSE(exif_time("2026:01:01 12:00:00", "", offset)->from_utc);
  }
}

TEST_CASE("stills whose times increase have those times, from the first on") {
  const StillTimes times = times_of(stills({{"2026:03:01 23:59:59", "90", ""},
                                            {"2026:03:02 00:00:00", "00", ""},
                                            {"2026:03:02 00:00:07", "25", ""}}));
  CHECK(times.trouble.empty());
  CHECK(times.since_first == std::vector<Instant>{{0s}, {100ms}, {7350ms}});
}

TEST_CASE("a clock that is set to another zone on the way goes on, where every still states its zone") {
  const StillTimes zoned = times_of(stills({{"2026:03:29 01:59:58", "", "+01:00"},
                                            {"2026:03:29 03:00:02", "", "+02:00"},
                                            {"2026:03:29 02:00:06", "", "+01:00"}}));
  CHECK(zoned.since_first == std::vector<Instant>{{0s}, {4s}, {8s}});
  const StillTimes unknown =
      times_of(stills({{"2026:03:29 01:00:00", "", "+01:00"}, {"2026:03:29 01:00:10", "", ""}}));
  CHECK(unknown.since_first == std::vector<Instant>{{0s}, {10s}});
}

TEST_CASE("stills whose counter began anew begin with the one that was taken first") {
  using Texts = std::vector<std::array<const char*, 3>>;
  const std::array<const char*, 3> noon{"2026:03:01 12:00:00", "", ""}, later{"2026:03:01 12:00:09", "", ""},
      evening{"2026:03:01 18:00:00", "", ""}, none{"", "", ""};
  CHECK(first_taken(stills({later, evening, noon, noon})) == 2);
  CHECK(first_taken(stills({later, later, noon, later})) == 2);
  for (const Texts& others :
       {Texts{}, Texts{noon}, Texts{noon, noon, later, evening}, Texts{later, noon, evening},
        Texts{later, noon, later, noon}, Texts{later, evening, none, noon}})
    CHECK(first_taken(stills(others)) == 0);
}

TEST_CASE("a pause between stills is five seconds or more, and four times what is usual between them") {
  using Texts = std::vector<std::array<const char*, 3>>;
  const auto at = [](const char* minute) { return std::array<const char*, 3>{minute, "", ""}; };
  const auto noon = at("2026:03:01 12:00:00"), second = at("2026:03:01 12:00:01"),
             fourth = at("2026:03:01 12:00:04"), fifth = at("2026:03:01 12:00:05"),
             later = at("2026:03:01 12:10:00"), evening = at("2026:03:01 18:00:00");
  const auto pause = first_pause(stills({noon, noon, second, later, later, evening}));
  REQUIRE(pause);
  CHECK(pause->before == 3);
  CHECK(pause->length == 599s);
  CHECK(first_pause(stills({noon, noon, fifth, fifth}))->before == 2);
  for (const Texts& others : {Texts{}, Texts{noon}, Texts{noon, later}, Texts{noon, noon, fourth, fourth},
                              Texts{noon, fifth, at("2026:03:01 12:00:11"), at("2026:03:01 12:00:24")},
                              Texts{noon, noon, at(""), later, later}})
    CHECK_FALSE(first_pause(stills(others)));
  const std::array<const char*, 3> winter{"2026:03:29 01:59:59", "", "+01:00"},
      summer{"2026:03:29 03:00:00", "", "+02:00"};
  CHECK_FALSE(first_pause(stills({winter, winter, summer, summer})));
}

TEST_CASE("times that are missing, run backward or are too coarse are not used, and it is said why") {
  CHECK(times_of(stills({{"", "", ""}, {"", "", ""}})).trouble.empty());
  const struct {
    std::vector<std::array<const char*, 3>> texts;
    const char* why;
  } cases[] = {
      {{{"2026:03:01 12:00:00", "", ""}, {"", "", ""}, {"2026:03:01 12:00:10", "", ""}},
       "2 of the 3 stills says when they were taken, that of 'b.jpg' does not"},
      {{{"2026:03:01 12:00:10", "", ""}, {"2026:03:01 12:00:20", "", ""}, {"2026:03:01 12:00:00", "", ""}},
       "'c.jpg' was taken before 'b.jpg' by EXIF"},
      {{{"2026:03:01 12:00:10", "", ""}, {"2026:03:01 12:00:13", "", ""}}, "steps of 1 s"},
      {{{"2026:03:01 12:00:10", "0", ""}, {"2026:03:01 12:00:10", "3", ""}}, "steps of 0.1 s"},
      {{{"2026:03:01 12:00:10", "00", ""}, {"2026:03:01 12:00:10", "00", ""}},
       "'a.jpg' and 'b.jpg' are 0 s apart"}};
  for (const auto& [texts, why] : cases) {
    const StillTimes times = times_of(stills(texts));
    CHECK(times.since_first.empty());
    CHECK_THAT(times.trouble, Contains(why));
  }
}
