#include "firmware_host/run/memory_need.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/recorded_labels.h"
#include "firmware_host/film/scene_keeper.h"
#include "firmware_host/run/pipeline_options.h"
#include "firmware_host/sinks/sink_table.h"
#include "hal/core/image.h"

namespace hdrcam {
namespace {

// Bytes for each pixel of the stream.
constexpr std::uint64_t kState = 285;
constexpr std::uint64_t kLongerLookAhead = 80;  // beside it: what waits for a second frame
constexpr std::uint64_t kFieldFrame = 100;   // of the field's window, and of two more, a pixel of the field
constexpr std::uint64_t kBesideField = 40;   // its priors, and its view of unseen pixels
constexpr std::uint64_t kQueuedFrame = 66;   // of a sink's copy of an HDR frame with all its layers
constexpr std::uint64_t kWrittenFrame = 20;  // of what the sink makes of it
constexpr std::uint64_t kSimulator = 200;
constexpr std::uint64_t kCodec = 24;           // packets and pictures of a recording's codec
constexpr std::uint64_t kFfv1Packet = 37 * 4;  // that FFmpeg's encoder asks for, whatever comes of it

// Of a copy, bytes for each pixel: fixed ones, and for each byte of a pixel in memory and in a file.
struct CopyNeed {
  double fixed, of_memory, of_file;
};
CopyNeed need_of(CopyKind kind) {
  switch (kind) {
    case CopyKind::Stills:
      return {14, 4, 3.5};
    case CopyKind::Video:  // with pictures to which others refer
      return {34, 4, 3.5};
    case CopyKind::Recording:
      return {10, 0, 12};
    case CopyKind::Export:
      return {4, 1.5, 8.5};
  }
  return {};
}
constexpr double kWhileJudged = 16;  // what reads frames while nothing is written yet
// Of frames that waited and are gone the allocator keeps a share, and of small ones more than of large ones.
constexpr double kKeptShare = 0.6, kMostKept_bytes = 24e6;

// What kCodec leaves out of writing.
std::uint64_t packet_of(RecordingCodec codec) { return codec == RecordingCodec::Ffv1 ? kFfv1Packet : 0; }

}  // namespace

std::uint64_t recording_bytes(const CameraFacts& camera) {
  const std::uint64_t frame = sizeof(std::uint16_t) * static_cast<std::uint64_t>(channels(camera.layout));
  return pixel_count(camera.height, camera.width) *
         (kCodec + frame * static_cast<std::uint64_t>(RecordedLabels::kBeginning + 2));
}

std::uint64_t sink_bytes(int width, int height, const Settings& settings) {
  const std::uint64_t frame = kQueuedFrame * pixel_count(height, width);
  const std::uint64_t one = frame * AsyncSink::slots_for(frame) + kWrittenFrame * pixel_count(height, width);
  std::uint64_t sinks = 0;
  for (const SinkKind& kind : sink_kinds()) {
    const bool has_pictures = kind.pace != SinkPace::Light || kind.target == SinkTarget::Address;
    if (has_pictures && !settings.output.path(kind.name).empty()) sinks += one;
  }
  return sinks;
}

std::uint64_t fit_bytes(int width, int height, const Settings& settings, FieldUse use) {
  return method_bytes(width, height, settings, use) + sink_bytes(width, height, settings);
}

std::uint64_t method_bytes(int width, int height, const Settings& settings, FieldUse use) {
  const Knobs knobs = options_of(settings, use).knobs;
  std::uint64_t per_pixel = kState;
  if (look_ahead_of(knobs, height, width) > 1) per_pixel += kLongerLookAhead;
  if (knobs.field != FieldKind::None) {
    const auto step = static_cast<std::uint64_t>(field_step_px(knobs.field_step, height, width));
    per_pixel += kBesideField +
                 kFieldFrame * static_cast<std::uint64_t>(knobs.hash_grid.window.frames + 2) / (step * step);
  }
  std::uint64_t scene = 0;
  if (!settings.output.path(Settings::Output::kSnapshot).empty())
    scene = kept_scene_bytes(width, height, knobs.hash_grid.window.frames,
                             field_step_px(knobs.field_step, height, width));
  return per_pixel * pixel_count(height, width) + scene;
}

std::uint64_t capture_bytes(int width, int height, PixelLayout layout, const Settings& settings,
                            int fewest_waiting, int most_waiting) {
  const std::uint64_t frame =
      sizeof(std::uint16_t) * static_cast<std::uint64_t>(channels(layout)) * pixel_count(height, width);
  const std::uint64_t waiting = std::clamp(static_cast<std::uint64_t>(settings.record.memory_mib) << 20,
                                           frame * static_cast<std::uint64_t>(fewest_waiting),
                                           frame * static_cast<std::uint64_t>(most_waiting));
  return waiting + frame * static_cast<std::uint64_t>(settings.camera.buffers) +
         (kCodec + packet_of(settings.record.codec)) * pixel_count(height, width);
}

std::uint64_t simulator_bytes(int width, int height) { return kSimulator * pixel_count(height, width); }

Result<void> admit_parts(const Settings& settings, const std::string& what, std::uint64_t bytes) {
  return memory_limit(settings).admit(what, kProgramBytes + bytes);
}

// Codes that fit into bytes are kept so once they are judged (capture/recording_stage.h).
std::uint64_t copy_bytes(const CameraFacts& camera, const FrameCopy& copy) {
  const double in_memory = static_cast<double>(sizeof(std::uint16_t)) * channels(camera.layout);
  const double in_file = camera.bits <= 8 ? in_memory / 2 : in_memory;
  const CopyNeed need = need_of(copy.kind);
  const double writing = need.fixed + need.of_memory * in_memory + need.of_file * in_file +
                         copy.waiting * in_file + static_cast<double>(packet_of(copy.codec));
  const double waiting = copy.waiting * in_memory;
  const auto pixels = static_cast<double>(pixel_count(camera.height, camera.width));
  return static_cast<std::uint64_t>(pixels * std::max(writing, kWhileJudged + waiting) +
                                    std::min(kMostKept_bytes, kKeptShare * pixels * waiting));
}

Result<void> admit_copy(const Settings& settings, const CameraFacts& camera, const FrameCopy& copy) {
  return admit_parts(settings, fmt::format("a copy of frames of {}x{}", camera.width, camera.height),
                     copy_bytes(camera, copy));
}

MemoryLimit memory_limit(const Settings& settings) {
  const int mib = settings.machine.memory_mib;
  return mib > 0 ? MemoryLimit(static_cast<std::uint64_t>(mib) << 20) : MemoryLimit::share_of_machine();
}

}  // namespace hdrcam
