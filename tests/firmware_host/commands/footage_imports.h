// Footage of a small scene with known exposures, and its import, as the user calls it. Include last: it
// brings Catch2.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "firmware_host/commands/command.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

inline Result<void> import_verb(const std::string& line) {
  CLI::App app;
  Verb verb;
  add_import(app, verb);
  app.parse("import " + line);
  const std::atomic<bool> stop = false;
  Surroundings around{posix_storage(), stop};
  return verb(around);
}

inline MovingScene scene() {
  MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  return scene;
}

// Which frames of the scene are filmed: `count` from `first`, without those that are lost.
inline std::vector<int> filmed(int first, int count, const std::vector<int>& lost) {
  std::vector<int> frames;
  for (int i = first; i < first + count; ++i)
    if (std::ranges::find(lost, i) == lost.end()) frames.push_back(i);
  return frames;
}

inline std::vector<Image<std::uint16_t>> pictures(const std::vector<int>& frames) {
  std::vector<Image<std::uint16_t>> all;
  for (const int i : frames) all.push_back(scene().frame(i).codes);
  return all;
}

// The recording's labels are those of the scene.
inline void check_labels(const std::string& recording, const std::vector<int>& frames) {
  const auto replayed = sample::replay(posix_storage(), recording);
  REQUIRE_FALSE(replayed.error);
  REQUIRE(replayed.frames.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameFacts& facts = replayed.frames[i].facts;
    const double truth_s = scene().exposures_s[static_cast<std::size_t>(frames[i]) % 3];
    INFO("frame " << i << " of " << recording);
    CHECK(facts.exposure_s == Approx(truth_s));
    CHECK(facts.slot == frames[i] % 3);
    CHECK(facts.sequence == static_cast<std::uint64_t>(frames[i] - frames[0]));
    CHECK((facts.flags & kFrameExposureUnproved) == 0);
  }
}

inline std::vector<double> times_in(const std::string& recording) {
  const auto replayed = sample::replay(posix_storage(), recording);
  REQUIRE_FALSE(replayed.error);
  std::vector<double> times_s;
  for (const RawFrame& frame : replayed.frames) times_s.push_back(frame.facts.timestamp.seconds());
  return times_s;
}

// A bracket of nine stills, taken at these times; an empty one is not in EXIF.
inline std::string write_bracket(const std::string& name,
                                 const std::vector<std::string>& times = std::vector<std::string>(9),
                                 const std::vector<std::string>& sub_seconds = std::vector<std::string>(9)) {
  const std::string folder = sample::scratch_folder(name);
  for (int i = 0; i < 9; ++i) {
    const auto place = static_cast<std::size_t>(i);
    Exif exif{static_cast<std::uint32_t>(std::lround(scene().exposures_s[place % 3] * 1000)), 1000, 100, 80};
    exif.date_time = times[place], exif.sub_second = sub_seconds[place];
    write_jpeg(fmt::format("{}/IMG_{}.JPG", folder, i), scene().frame(i).codes, exif);
  }
  return folder;
}

}  // namespace hdrcam::test
