// A frame as its source delivers it, with every fact about it; independent of HDR. Codes are those of the
// sensor, [channels, rows, cols]; exposures in seconds and gains; camera axes x right, y down, z forward.
// Plain values, copyable (pictures are moved); reentrant.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/black_level.h"
#include "hal/core/image.h"
#include "hal/core/instant.h"
#include "hal/core/pose_matrix.h"

namespace hdrcam {

struct Intrinsics {
  double fx_px = 0, fy_px = 0;  // focal lengths
  double cx_px = 0, cy_px = 0;  // principal point, pixel centres at +0.5
};

// Where the exposure value of a frame comes from, best first. Estimated: nobody stated any exposure of the
// clip; the pictures' ratios gave them all, so they are relative to each other and no times.
enum class ExposureSource { Embedded, Reported, Declared, Predicted, Photometric, Estimated, Unknown };
inline constexpr ExposureSource kExposureSources[] = {ExposureSource::Embedded,    ExposureSource::Reported,
                                                      ExposureSource::Declared,    ExposureSource::Predicted,
                                                      ExposureSource::Photometric, ExposureSource::Estimated,
                                                      ExposureSource::Unknown};
const char* name(ExposureSource source);

// How certain the exposure of a frame is, judged by pictures and strobe (capture/exposure_proof.h).
// Estimated: the pictures agree with an exposure that has itself been estimated from them.
enum class Verdict { Proved, Plausible, Estimated, Contradicted, Unknown };
inline constexpr Verdict kVerdicts[] = {Verdict::Proved, Verdict::Plausible, Verdict::Estimated,
                                        Verdict::Contradicted, Verdict::Unknown};
const char* name(Verdict verdict);

enum class PixelLayout { Rgb, Mono, BayerRggb, BayerGrbg, BayerGbrg, BayerBggr };
const char* name(PixelLayout layout);
inline int channels(PixelLayout layout) { return layout == PixelLayout::Rgb ? 3 : 1; }
constexpr bool is_bayer(PixelLayout layout) {
  return layout != PixelLayout::Rgb && layout != PixelLayout::Mono;
}

// Factors of R, G and B.
using ChannelGains = std::array<double, 3>;

struct CameraFacts {
  std::string name;           // of the camera or clip; "": none is known
  int width = 0, height = 0;  // pixels
  double framerate_hz = 30;
  int bits = 8;  // significant bits of a code, 8..16
  PixelLayout layout = PixelLayout::Rgb;
  bool linear = false;  // codes are proportional to light (raw)
  std::optional<Intrinsics> intrinsics;
  std::vector<std::vector<double>> response;  // [rgb][256] code/max -> relative exposure, empty if unknown
  // What the camera would multiply its codes with to make the scene's light grey, G = 1. It is not applied.
  std::optional<ChannelGains> white_balance;
  // The pictures of a clip were turned when it was imported: its rows were not read out from top to bottom.
  bool turned_upright = false;
};

// As messages call it: "'walk'", or "the clip" where it has no name.
std::string called(const CameraFacts& camera);

// The facts of one frame. Exposure product E = exposure_s * analogue_gain * digital_gain.
struct FrameFacts {
  std::uint64_t sequence = 0;  // the sensor's counter; a gap is a dropped frame
  Instant timestamp;           // centre of the exposure, under a rolling shutter that of the middle row
  double exposure_s = 0;
  double analogue_gain = 1, digital_gain = 1;
  // Read-out of a rolling shutter: by how much each row is exposed later than the one above it, times the
  // rows; 0: none known.
  double readout_s = 0;
  int slot = -1;                          // position in the exposure schedule, -1 unknown
  std::optional<BlackLevel> black_level;  // as device or user state it
  ExposureSource exposure_source = ExposureSource::Declared;
  std::optional<Verdict> verdict;            // on the exposure; none: not judged yet
  std::optional<double> exposure_within_ev;  // uncertainty of a judged exposure, stops
  std::uint32_t flags = 0;                   // FrameFlag bits
  std::optional<PoseMatrix> T_world_camera;  // metres

  double exposure() const { return exposure_s * analogue_gain * digital_gain; }
  double gain() const { return analogue_gain * digital_gain; }
  // Whether exposure() is one; 0 and NaN stand for an unknown one.
  bool has_exposure() const { return exposure() > 0 && std::isfinite(exposure()); }
  // Whether exposure_s is a time, and not only a ratio to the clip's other exposures.
  bool has_exposure_time() const { return exposure_source != ExposureSource::Estimated; }
};

enum FrameFlag : std::uint32_t {
  kFrameExposureUnproved = 1u << 0,  // contradicted or unknown: keep out of the fit
  kFrameAfterDrop = 1u << 1,         // the previous frame was lost
  kFrameDamaged = 1u << 2,           // pixels are not trustworthy
  // The trigger pulse was late: the frame is not of the planned instant, or not of the planned exposure. Its
  // label is the measured one.
  kFrameTriggerLate = 1u << 3,
};

struct RawFrame {
  FrameFacts facts;
  Image<std::uint16_t> codes;  // [channels(layout), rows, cols], 0 .. 2^bits-1
};

}  // namespace hdrcam
