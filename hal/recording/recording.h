// What a recording holds: raw frames and every fact about them. It knows no HDR. The container (FFV1 in
// Matroska, facts in a JSON data track) is specified in docs/recording.md. Plain values; the reader and the
// writer are thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/instant.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

struct Intrinsics {
  double fx_px = 0, fy_px = 0;  // focal lengths
  double cx_px = 0, cy_px = 0;  // principal point, pixel centres at +0.5
};

// A rigid transform T_world_camera, row-major 3x4; camera axes x right, y down, z forward, metres.
using PoseMatrix = std::array<double, 12>;

// Where the exposure value of a frame comes from, best first.
enum class ExposureSource { Embedded, Reported, Declared, Predicted, Photometric, Unknown };
const char* name(ExposureSource source);

enum class PixelLayout { Rgb, Mono, BayerRggb, BayerGrbg, BayerGbrg, BayerBggr };
const char* name(PixelLayout layout);
inline int channels(PixelLayout layout) { return layout == PixelLayout::Rgb ? 3 : 1; }

struct CameraFacts {
  std::string name;           // of the camera or clip
  int width = 0, height = 0;  // pixels
  double framerate_hz = 30;
  int bits = 8;  // significant bits of a code, 8..16
  PixelLayout layout = PixelLayout::Rgb;
  bool linear = false;  // codes are proportional to light (raw)
  std::optional<Intrinsics> intrinsics;
  std::vector<std::vector<double>> response;  // [rgb][256] code/max -> relative exposure, empty if unknown
};

// The facts of one frame. Exposure product E = exposure_s * analogue_gain * digital_gain.
struct FrameFacts {
  std::uint64_t sequence = 0;  // the sensor's counter; a gap is a dropped frame
  Instant timestamp;           // centre of the exposure
  double exposure_s = 0;
  double analogue_gain = 1, digital_gain = 1;
  int slot = -1;           // position in the exposure schedule, -1 unknown
  double black_level = 0;  // in codes, 0 unless the device reports one
  ExposureSource exposure_source = ExposureSource::Declared;
  std::uint32_t flags = 0;  // FrameFlag bits
  std::optional<PoseMatrix> T_world_camera;

  double exposure() const { return exposure_s * analogue_gain * digital_gain; }
};

enum FrameFlag : std::uint32_t {
  kFrameExposureUnproved = 1u << 0,  // keep out of the response estimate
  kFrameAfterDrop = 1u << 1,         // the frame before it was lost
  kFrameDamaged = 1u << 2,           // pixels are not trustworthy
};

struct RawFrame {
  FrameFacts facts;
  Image<std::uint16_t> codes;  // [channels(layout), rows, cols], 0 .. 2^bits-1
};

class RecordingWriter {
 public:
  virtual ~RecordingWriter() = default;
  // Appends one frame, whole, before it returns. Errors: SizeChanged, Invalid (a code beyond `bits`),
  // NoSpace, Io.
  virtual Result<void> append(const RawFrame& frame) = 0;
  // Writes the end record and the index. Without it the file reads up to its last whole cluster.
  virtual Result<void> finish() = 0;
};

class RecordingReader {
 public:
  virtual ~RecordingReader() = default;
  virtual const CameraFacts& camera() const = 0;
  // Frames in the index, or nullopt where the file was cut before it was written.
  virtual std::optional<int> frame_count() const = 0;
  // The next frame; nullopt at the end. Truncated where the file was cut, after all its whole frames.
  virtual Result<std::optional<RawFrame>> next() = 0;
  // As next(), but the pixels are only checked, not decoded: for whoever lists a recording.
  virtual Result<std::optional<FrameFacts>> next_facts();
};

constexpr int kMinSidePx = 2,
              kMaxSidePx = 16384;  // of a recording; the FFV1 of FFmpeg 5.1 loses pictures of one line

// Errors: Exists where there is a file that may not be replaced; Permission, also for a device or a FIFO;
// NoSpace, Io; Invalid for a size or bit depth that the container cannot hold. Once a write has failed, every
// later call returns the same error.
Result<std::unique_ptr<RecordingWriter>> create_recording(Storage& storage, const std::string& path,
                                                          const CameraFacts& camera,
                                                          Creation how = Creation::New);
// Errors: NotFound, Permission, NotRecording, Corrupt, Truncated (cut before the first whole frame),
// Unsupported (a newer format).
Result<std::unique_ptr<RecordingReader>> open_recording(Storage& storage, const std::string& path);

}  // namespace hdrcam
