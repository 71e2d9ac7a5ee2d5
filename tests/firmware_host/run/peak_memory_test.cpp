// What the program takes of memory, on honest recordings of two sizes: the most that was resident, as the
// kernel counts it for the process.

#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "capture/recorded_labels.h"
#include "firmware_host/run/memory_need.h"
#include "hal/recording/png_image.h"
#include "tests/allocations.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/not_tested.h"
#include "tests/support/process.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::started;
using test::status_word;

namespace {

constexpr std::uint64_t kMegabyte = 1'000'000;

// A texture of ten stops that moves to the left, at 1, 4 and 16 ms.
RawFrame textured_frame(int index, int width, int height) {
  RawFrame raw;
  raw.facts.sequence = static_cast<std::uint64_t>(index);
  raw.facts.timestamp = Instant::from_seconds(index / 30.0);
  raw.facts.exposure_s = 0.001 * std::pow(4.0, index % 3);
  raw.codes = Image<std::uint16_t>(3, height, width);
  const float shift = 3.f * static_cast<float>(index);
  std::vector<float> across(static_cast<std::size_t>(width)), fine(across.size());
  for (std::size_t x = 0; x < across.size(); ++x) {
    const float u = static_cast<float>(x) + shift;
    across[x] = std::exp2(2 * std::sin(u * 0.011f) + std::sin(u * 0.07f));
    fine[x] = std::sin(u * 0.31f);
  }
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y) {
      const float v = static_cast<float>(y), k = 0.25f * std::sin(v * 0.23f + static_cast<float>(c));
      const float down =
          std::exp2(-4 + 2 * std::sin(v * 0.013f)) * static_cast<float>(raw.facts.exposure_s) * 250;
      std::uint16_t* row = raw.codes.row(c, y);
      for (std::size_t x = 0; x < across.size(); ++x)
        row[x] =
            static_cast<std::uint16_t>(255 * std::sqrt(std::min(1.f, across[x] * (1 + k * fine[x]) * down)));
    }
  return raw;
}

CameraFacts camera_of(int width, int height) {
  CameraFacts camera;
  camera.name = "texture";
  camera.width = width, camera.height = height;
  return camera;
}

std::string recorded(const std::string& folder, int width, int height, int frames) {
  std::string path = folder + "/clip.mkv";
  auto writer = create_recording(posix_storage(), path, camera_of(width, height), Creation::New);
  REQUIRE(writer.ok());
  for (int i = 0; i < frames; ++i) REQUIRE(writer.value()->append(textured_frame(i, width, height)).ok());
  REQUIRE(writer.value()->finish().ok());
  return path;
}

// The most memory that the program takes for these arguments.
std::uint64_t peak_bytes(const std::vector<std::string>& words) {
  const pid_t process = started(words);
  std::uint64_t most = 0;
  int status = 0;
  while (waitpid(process, &status, WNOHANG) == 0) {
    const std::string kib = status_word(process, "VmHWM:");  // none once it has ended
    if (!kib.empty()) most = std::max<std::uint64_t>(most, std::stoull(kib) * 1024);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return most;
}

// The peak of a replay to EXR files with two threads, and what was estimated for it.
struct Taken {
  std::uint64_t peak, estimated;
};
Taken taken(const std::string& clip, int width, int height, Preset preset, EmitLayer emit) {
  const std::string folder = sample::scratch_folder("peak_memory_frames");
  Settings settings;
  settings.fit.preset = preset, settings.fit.emit = emit;
  settings.output.paths["frames"] = folder + "/%06d.exr";
  const std::uint64_t peak = peak_bytes({"replay", clip, "--preset", name(preset), "--emit",
                                         emit == EmitLayer::State ? "state" : "merged", "--threads", "2",
                                         "-o", settings.output.paths["frames"]});
  return {peak,
          kProgramBytes + recording_bytes(camera_of(width, height)) + fit_bytes(width, height, settings)};
}

void check_taken(int width, int height, int frames, EmitLayer emit, std::vector<Preset> presets,
                 std::uint64_t bound) {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer takes memory of its own: no test bounds a peak in this build");
    return;
  }
  const std::string clip = recorded(sample::scratch_folder("peak_memory"), width, height, frames);
  for (const Preset preset : presets) {
    const Taken of = taken(clip, width, height, preset, emit);
    CAPTURE(name(preset), of.peak / kMegabyte, of.estimated / kMegabyte);
    CHECK(of.peak <= bound);
    CHECK(of.peak <= of.estimated);
    CHECK(2 * of.estimated <= 3 * of.peak);  // nobody is refused for nothing
  }
}

// Stills of noise, which no codec makes smaller. Returns their folder.
std::string noisy_stills(int count, const CameraFacts& camera) {
  const std::string folder = sample::scratch_folder("peak_memory_stills");
  std::mt19937 random(7);
  std::uniform_int_distribution<int> code(0, (1 << camera.bits) - 1);
  PngImage still{camera.bits, Image<std::uint16_t>(3, camera.height, camera.width)};
  for (int i = 0; i < count; ++i) {
    for (std::uint16_t& sample : still.samples.samples()) sample = static_cast<std::uint16_t>(code(random));
    const std::vector<std::byte> file = png_file(still, PngEase::Fast).value();
    REQUIRE(write_whole(posix_storage(), fmt::format("{}/{}.png", folder, i), file).ok());
  }
  return folder;
}

void check_copy(const std::vector<std::string>& words, const CameraFacts& camera, const FrameCopy& copy) {
  const std::uint64_t peak = peak_bytes(words), estimated = kProgramBytes + copy_bytes(camera, copy);
  CAPTURE(words.front(), camera.bits, copy.waiting, peak / kMegabyte, estimated / kMegabyte);
  CHECK(peak <= estimated);
  CHECK(2 * estimated <= 3 * peak);
}

}  // namespace

TEST_CASE("statistics and poses need no memory for pictures") {
  Settings settings;
  settings.output.paths["frames"] = "out/%06d.exr";
  const std::uint64_t frames = sink_bytes(1920, 1080, settings);
  CHECK(frames > 0);
  for (const char* figures : {"stats", "transforms", "colmap"}) settings.output.paths[figures] = "somewhere";
  CHECK(sink_bytes(1920, 1080, settings) == frames);
  settings.output.paths["http"] = "127.0.0.1:0";
  CHECK(sink_bytes(1920, 1080, settings) == 2 * frames);
}

TEST_CASE("a copy takes no more memory than was estimated, and that was no more than it needs", "[memory]") {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer takes memory of its own: no test bounds a peak in this build");
    return;
  }
  CameraFacts camera = camera_of(1200, 800);
  const std::string out = sample::scratch_folder("peak_memory_copy"), clip = out + "/x.mkv";
  const auto check_import = [&](int stills, const FrameCopy& copy) {
    check_copy({"import", noisy_stills(stills, camera), "--shutter", "4ms", "--force", "-o", clip}, camera,
               copy);
  };
  check_import(13, {CopyKind::Stills, RecordedLabels::kBeginning});  // of 8 bits
  camera.bits = 16;
  check_import(13, {CopyKind::Stills, RecordedLabels::kBeginning});
  check_import(2, {CopyKind::Stills, 2});
  check_copy({"repair", clip, "-o", out + "/y.mkv"}, camera, {CopyKind::Recording});
  check_copy({"export", clip, "-o", out + "/frames"}, camera, {CopyKind::Export});
}

TEST_CASE(
    "the packet of FFV1, which FFmpeg asks for whatever comes of it, is estimated with a camera's frames") {
  Settings settings;
  const std::uint64_t usual = capture_bytes(64, 48, PixelLayout::Rgb, settings, 1, 1);
  settings.record.codec = RecordingCodec::Ffv1;
  CHECK(capture_bytes(64, 48, PixelLayout::Rgb, settings, 1, 1) - usual == std::uint64_t{148} * 64 * 48);
}

TEST_CASE("frames that wait for the disk are estimated as far as there are any, whatever is allowed them") {
  constexpr int kFewest = 12, kMost = 4096;
  Settings settings;
  const auto needed = [&](int width, int height, int memory_mib, PixelLayout layout = PixelLayout::Rgb) {
    settings.record.memory_mib = memory_mib;
    return capture_bytes(width, height, layout, settings, kFewest, kMost);
  };
  constexpr std::uint64_t kFrame = 64 * 48 * 3 * sizeof(std::uint16_t);
  CHECK(needed(64, 48, 65536) == needed(64, 48, 256));
  CHECK(needed(64, 48, 256) - needed(64, 48, 1) == kMost * kFrame - (1U << 20));
  CHECK(needed(640, 480, 512) - needed(640, 480, 256) == 256U << 20);
  CHECK(needed(1920, 1080, 1) == needed(1920, 1080, 2));
  // of a mosaic two planes less, in each that waits and in each buffer
  const auto frames = static_cast<std::uint64_t>(kFewest + settings.camera.buffers);
  CHECK(needed(1920, 1080, 1) - needed(1920, 1080, 1, PixelLayout::BayerRggb) ==
        frames * 2 * sizeof(std::uint16_t) * 1920 * 1080);
}

TEST_CASE(
    "an honest recording of 320x240 takes less than 160 MB and one of 640x480 less than 256 MB, no more than "
    "was "
    "estimated",
    "[memory]") {
  check_taken(320, 240, 9, EmitLayer::Merged, {Preset::Realtime, Preset::Balanced}, 160 * kMegabyte);
  check_taken(640, 480, 9, EmitLayer::State, {Preset::Realtime, Preset::Balanced}, 256 * kMegabyte);
  check_taken(640, 480, 9, EmitLayer::Merged, {Preset::Balanced}, 256 * kMegabyte);
}

// They take some ten seconds each: by name only.
TEST_CASE("an honest recording of 1920x1080 takes less than 1 GB, and no more than was estimated",
          "[.memory-1080]") {
  check_taken(1920, 1080, 9, EmitLayer::State, {Preset::Realtime, Preset::Balanced}, 1000 * kMegabyte);
  check_taken(1920, 1080, 9, EmitLayer::Merged, {Preset::Balanced}, 1000 * kMegabyte);
}
