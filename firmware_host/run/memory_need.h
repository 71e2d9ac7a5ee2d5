// What the parts of a run need of memory, from the size of the pictures, for MemoryLimit: measured on
// simulated clips of 640x480 to 1920x1080 and rounded up. Reentrant.
#pragma once

#include <cstdint>

#include "firmware_host/run/budget_ladder.h"
#include "firmware_host/settings/settings.h"
#include "hal/core/frame.h"
#include "hal/core/memory_limit.h"
#include "hal/recording/recording.h"

namespace hdrcam {

// The program itself, its threads and libraries; the parts below come on top.
constexpr std::uint64_t kProgramBytes = 64ULL << 20;

// Reading or writing a recording or a clip: some frames that wait, the codec's own.
std::uint64_t recording_bytes(const CameraFacts& camera);
// The method and the sinks behind it; use: what the run has the field for, beside what the settings show of
// it.
std::uint64_t fit_bytes(int width, int height, const Settings& settings, FieldUse use = FieldUse::Fills);
// The method alone.
std::uint64_t method_bytes(int width, int height, const Settings& settings, FieldUse use);
// The outputs alone, of pictures of this size: those that hold pictures, which statistics and poses do not.
std::uint64_t sink_bytes(int width, int height, const Settings& settings);
// A camera's buffers, and the frames of this layout that wait for the disk, at least and at most so many.
std::uint64_t capture_bytes(int width, int height, PixelLayout layout, const Settings& settings,
                            int fewest_waiting, int most_waiting);
// The simulated sensor with its scene.
std::uint64_t simulator_bytes(int width, int height);

// Whether a run of these parts may begin. what: as MemoryLimit::admit takes it.
Result<void> admit_parts(const Settings& settings, const std::string& what, std::uint64_t bytes);
// Frames that are read and written one by one.
enum class CopyKind { Stills, Video, Recording, Export };  // what is read; Export: a recording into pictures
struct FrameCopy {
  CopyKind kind = CopyKind::Recording;
  int waiting = 0;  // frames, at most, that are judged together before the first is written
  RecordingCodec codec = RecordingCodec::Huffyuv;  // that writes
};
// Measured on noise, which no codec makes smaller: what compresses well takes down to half.
std::uint64_t copy_bytes(const CameraFacts& camera, const FrameCopy& copy);
// Whether frames of this camera may be copied.
Result<void> admit_copy(const Settings& settings, const CameraFacts& camera, const FrameCopy& copy);

// As the settings say, or a share of the machine.
MemoryLimit memory_limit(const Settings& settings);

}  // namespace hdrcam
