#include "firmware_host/sinks/frame_pattern.h"

#include <string>

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("a pattern names one file per sequence number, in the folder it says") {
  const auto pattern = FramePattern::parse("--output", "out/walk/%06d.exr", ".exr");
  REQUIRE(pattern.ok());
  CHECK(pattern.value().path(0) == "out/walk/000000.exr");
  CHECK(pattern.value().path(1234567) == "out/walk/1234567.exr");
  CHECK(pattern.value().folder() == "out/walk");
  CHECK(FramePattern::parse("--output", "f_%04d_v2.exr", ".exr").value().path(7) == "f_0007_v2.exr");
  CHECK(FramePattern::parse("--output", "%04d.exr", ".exr").value().folder() == ".");
  CHECK(FramePattern::parse("--output", "/%04d.exr", ".exr").value().folder() == "/");
}

TEST_CASE("the number of a file is found again in its name") {
  const auto pattern = FramePattern::parse("--output", "out/f_%04d_v2.exr", ".exr").value();
  CHECK(pattern.sequence_of("f_0007_v2.exr") == 7);
  CHECK(pattern.sequence_of("f_12345_v2.exr") == 12345);
  for (const char* stranger : {"f_007_v2.exr", "f_00007_v2.exr", "f__v2.exr", "f_0007.exr", "g_0007_v2.exr",
                               "f_00a7_v2.exr", "f_-007_v2.exr", ""})
    CHECK_FALSE(pattern.sequence_of(stranger));
  const auto number_alone = FramePattern::parse("--output", "out/%06d.exr", ".exr").value();
  CHECK(number_alone.sequence_of("000003.exr") == 3);
  CHECK_FALSE(number_alone.sequence_of("0003.exr"));  // the end of a name is not the name
}

TEST_CASE("a file fits a pattern with any number of digits, and with nothing else in their place") {
  const auto pattern = FramePattern::parse("--output", "out/f_%04d_v2.exr", ".exr").value();
  for (const char* like : {"f_0007_v2.exr", "f_7_v2.exr", "f_00000000000000000000000007_v2.exr"})
    CHECK(pattern.fits(like));
  for (const char* stranger :
       {"f__v2.exr", "f_0007.exr", "g_0007_v2.exr", "f_00a7_v2.exr", "f_-007_v2.exr", ""})
    CHECK_FALSE(pattern.fits(stranger));
  const auto names = [](const char* text) { return FramePattern::parse("--output", text, ".exr").value(); };
  CHECK(pattern.same_names_but_for_digits(names("elsewhere/f_%06d_v2.exr")));
  CHECK_FALSE(pattern.same_names_but_for_digits(names("out/f_%04d.exr")));
  CHECK_FALSE(pattern.same_names_but_for_digits(names("out/%04d_v2.exr")));
}

TEST_CASE("a number of 64 bits keeps all its digits") {
  const auto pattern = FramePattern::parse("--output", "%019d.exr", ".exr");
  CHECK(pattern.value().path(UINT64_MAX) == "18446744073709551615.exr");
}

TEST_CASE("a pattern that would lose frames or reach printf is refused with the right spelling beside it") {
  for (const std::string text : {"out/frame.exr", "out/%d.exr", "out/%6d.exr", "out/%06d/%06d.exr",
                                 "out/%s.exr", "out/%06d.png", "out/%06d", "out/%06x.exr", "out/%%06d.exr",
                                 "out/%00d.exr", "out/%020d.exr", "out/%0999999999999d.exr", "%06d/frame.exr",
                                 "out/%", "%0", "", "%n.exr", "out/%-06d.exr", "out/%06ld.exr"}) {
    INFO(text);
    const auto pattern = FramePattern::parse("--output", text, ".exr");
    REQUIRE_FALSE(pattern.ok());
    CHECK(pattern.error().code == ErrorCode::Invalid);
    CHECK_THAT(pattern.error().message, Contains("--output '" + text + "'") && Contains("'out/%06d.exr'"));
  }
}

TEST_CASE(
    "a percent sign in a folder's name is a character like others, and a frame number there is refused") {
  const auto pattern = FramePattern::parse("--output", "50%/a%d b%/%06d.exr", ".exr");
  REQUIRE(pattern.ok());
  CHECK(pattern.value().folder() == "50%/a%d b%");
  CHECK(pattern.value().path(7) == "50%/a%d b%/000007.exr");
  CHECK(FramePattern::is_one("50%/%06d.png"));
  for (const char* one_file : {"50%.mp4", "50%/out.mp4", "50% %.json", "out.exr", "%06d/out.exr", ""})
    CHECK_FALSE(FramePattern::is_one(one_file));
  CHECK_THAT(FramePattern::parse("--output", "50%/%06d/%06d.exr", ".exr").error().message,
             Contains("has the frame number in a folder's name"));
}

TEST_CASE("a folder in place of a pattern is told with its own name how to be numbered") {
  const auto message = [](const char* flag, const char* text, const char* extension) {
    return FramePattern::parse(flag, text, extension).error().message;
  };
  CHECK_THAT(message("--output", "frames", ".exr"),
             Contains("'frames' names no files; write it as 'frames/%06d.exr', or name a video"));
  CHECK_THAT(message("--preview", "a/b//", ".png"), Contains("write it as 'a/b/%06d.png'"));
  CHECK_THAT(message("--http-record", "takes", ".mkv"), Contains("write it as 'takes/%03d.mkv'"));
  CHECK_THAT(message("--output", "/", ".exr"), Contains("write it as '/%06d.exr'"));
  CHECK_THAT(message("--output", "frame.exr", ".exr"), Contains("would put every frame into one file"));
  CHECK_THAT(message("--http-record", "-", ".mkv"),
             Contains("would put every recording into one file; write it as 'takes/%03d.mkv'"));
  CHECK_THAT(message("--http-record", "takes/%d.mkv", ".mkv"),
             Contains("not a recording number like '%03d'; write it as 'takes/%03d.mkv'"));
}

TEST_CASE("a single file for all frames leads to the videos, where the output may be one") {
  const auto message = [](const char* flag, const char* text, const char* extension) {
    return FramePattern::parse(flag, text, extension).error().message;
  };
  CHECK_THAT(message("--output", "v.avi", ".exr"), Contains("out.mp4, out.mov or out.mkv"));
  CHECK_THAT(message("--preview", "v.avi", ".png"), !Contains("out.mp4"));
  CHECK_THAT(message("--output", "out/%06d.png", ".exr"),
             Contains("'out/%06d.exr', or give it to --preview"));
}

TEST_CASE("a pattern of recordings that is refused is said to be one, not one of frames") {
  for (const char* text : {"takes/take.mkv", "takes/%03d/take.mkv", "takes/%s.mkv"}) {
    INFO(text);
    const auto pattern = FramePattern::parse("--http-record", text, ".mkv");
    REQUIRE_FALSE(pattern.ok());
    CHECK_THAT(pattern.error().message,
               Contains("recording") && !Contains("frame") && Contains("write it as 'takes/%03d.mkv'"));
  }
}

TEST_CASE("the digits at the end of a frame's name are counted") {
  CHECK(digits_at_end("f0041") == 4);
  CHECK(digits_at_end("take2_7") == 1);
  CHECK(digits_at_end("000123") == 6);
  CHECK(digits_at_end("f12b") == 0);
  CHECK(digits_at_end("") == 0);
}
