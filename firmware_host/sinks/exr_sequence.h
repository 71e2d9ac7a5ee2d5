// HDR frames as OpenEXR files, one per frame, numbered by the sensor's sequence. Each file is written under a
// temporary name and renamed when complete, so a reader that watches the folder never sees half a frame.
// frames.csv in the same folder (a_frames.csv beside a_000001.exr) lists time and exposure of each frame
// (frame_ledger.h). An attribute of the file states the unit of each layer.
//   R G B               always: scene-linear radiance, half; 1 saturates the clip's reference exposure
//   Z                   depth, float: metres where poses are given, else units of the tracked poses; 0 where
//                       there is none
//   backward.u/.v       motion to the previous frame, float, pixels; 0 for the first frame
//   forward.u/.v        motion to the next frame, likewise; 0 for the last frame
//   field.u/.v          the field's own motion to the previous frame, likewise
//   field.forward.u/.v  and to the next one
//   sigma               standard deviation of ln(radiance + white / 5000), half
//   confidence          exp(-sigma), half, 0..1: the one-sigma lower bound over the value
//   provenance          enum Provenance, half
// The sink is thread-bound; the rest is reentrant.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"
#include "render/exr.h"

namespace hdrcam {

// The channels besides radiance.
struct ExrLayers {
  bool depth = false, flow = false, flow_forward = false, field_flow = false, field_flow_forward = false;
  bool confidence = false, provenance = false;
};

struct ExrSequenceOptions {
  ExrLayers layers = {};
  ExrCompression compression = kUsualCompression;
  std::optional<double> framerate_hz = std::nullopt;  // of the camera: framesPerSecond and timeCode
  // Luminance of radiance 1, where the camera has been calibrated.
  std::optional<double> white_cd_m2 = std::nullopt;
  std::string owner = {};  // written where not empty
};

// What a file says of its place in the run, for whoever makes a video of the files. Each is none where
// the file states none, or an impossible one.
struct RunFacts {
  std::optional<double> since_start_s;  // from the first frame of the run to this one
  std::optional<double> white;          // radiance that saturates the shortest exposure
};
RunFacts run_facts_of(const ExrAttributes& attributes);

// One frame as such a file has it. start: the time of the run's first frame. Errors: those of encode_exr.
Result<std::vector<std::byte>> encode_frame(const HdrFrame& frame, const ExrSequenceOptions& options,
                                            Instant start);

// pattern: "out/%06d.exr" (frame_pattern.h); its folder is created. The storage outlives the sink.
// Errors: Invalid (pattern), Permission, NoSpace, Io.
Result<std::unique_ptr<FrameSink>> create_exr_sequence(Storage& storage, std::string_view pattern,
                                                       ExrSequenceOptions options);

}  // namespace hdrcam
