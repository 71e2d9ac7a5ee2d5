// A small recording with known frames, for tests that damage it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/recording/recording.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

namespace hdrcam::sample {

struct StoredSample {
  std::string path;
  CameraFacts camera;
  std::vector<RawFrame> frames;
  std::uint64_t bytes = 0;
};

// Of four frames of 7x5 pixels.
inline StoredSample small_recording(const std::string& name, PixelLayout layout = PixelLayout::Rgb) {
  StoredSample made{scratch_folder(name) + "/x.mkv", camera(layout, 8, 7, 5), {}, 0};
  made.frames = frames(made.camera, 4, 21);
  REQUIRE(record(posix_storage(), made.path, made.camera, made.frames).ok());
  made.bytes = std::filesystem::file_size(made.path);
  return made;
}

}  // namespace hdrcam::sample
