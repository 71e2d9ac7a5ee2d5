// Encodes pictures as OpenEXR bytes and decodes them, in memory; Storage writes the files. One part, scan
// lines, any set of named channels of one size. Reentrant. Channel names of an HDR frame are fixed below, so
// that writers and readers agree. Every sample is finite: a NaN or Inf passed to encode_exr is a bug of the
// caller, and a value above the range of half (65504) is clamped to it.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/storage.h"
#include "render/time_code.h"

namespace hdrcam {

namespace exr_channel {
inline constexpr std::string_view kRadiance[3] = {"R", "G", "B"};  // L, scene-linear
inline constexpr std::string_view kDepth = "Z";                    // camera z
inline constexpr std::string_view kFlowBackward[2] = {"backward.u",
                                                      "backward.v"};  // pixels to the previous frame
inline constexpr std::string_view kFlowForward[2] = {"forward.u", "forward.v"};  // pixels to the next frame
inline constexpr std::string_view kFieldFlow[2] = {"field.u", "field.v"};  // the field's, to the previous
inline constexpr std::string_view kFieldFlowForward[2] = {"field.forward.u", "field.forward.v"};
inline constexpr std::string_view kSigma = "sigma";            // HdrFrame::sigma
inline constexpr std::string_view kProvenance = "provenance";  // enum Provenance, 0..4
}  // namespace exr_channel

// Of a film's frame, among ExrAttributes::texts: HdrFrame::recorded_s.
inline constexpr const char* kExrRecordedSeconds = "hdrcam.secondsInRecording";

enum class ExrSample { Half, Float };
enum class ExrCompression { None, Rle, Zip, Piz };                        // the largest files first
inline constexpr ExrCompression kUsualCompression = ExrCompression::Piz;  // faster than Zip (README)

// CIE 1931 xy of the primaries and of white; the default is Rec. ITU-R BT.709-6, D65.
struct Chromaticities {
  std::array<float, 2> red = {0.64f, 0.33f}, green = {0.30f, 0.60f}, blue = {0.15f, 0.06f},
                       white = {0.3127f, 0.3290f};

  friend bool operator==(const Chromaticities&, const Chromaticities&) = default;
};

// The standard attributes of OpenEXR ("Standard Optional Attributes"), each written only where it is known.
struct ExrAttributes {
  std::optional<double> exposure_s;  // expTime
  // framesPerSecond, nominal (hal/recording/nominal_rate.h)
  std::optional<double> framerate_hz;
  std::optional<double> white_cd_m2;             // whiteLuminance, of (1, 1, 1)
  std::optional<Chromaticities> chromaticities;  // chromaticities
  std::optional<TimeCode> time_code;             // timeCode
  // worldToCamera holds its inverse, transposed (row vectors), of a camera with OpenEXR's axes, where y is up
  std::optional<PoseMatrix> T_world_camera;
  std::string owner, comments;  // owner, comments; empty: not written
  // Attributes outside the standard, each named "hdrcam.", with the value as text.
  std::map<std::string, std::string> texts;
};

struct ExrChannel {
  std::string name;
  std::span<const float> samples;  // [rows, cols], finite
  ExrSample stored = ExrSample::Half;
};

// The picture to write: a view; the caller keeps the samples.
struct ExrPicture {
  int rows = 0, cols = 0;
  std::vector<ExrChannel> channels;  // in any order, names distinct
  ExrAttributes attributes;
  ExrCompression compression = kUsualCompression;
};

// A decoded picture.
struct ExrImage {
  std::vector<std::string> names;  // of the channels, as sorted in the file
  Image<float> samples;            // [channels, rows, cols]
  ExrAttributes attributes;

  // Index into samples, or nullopt where the file has no such channel.
  std::optional<int> find(std::string_view name) const;
};

// room: a file that is done with, whose memory this one may take. Errors: Io where the library fails (out of
// memory).
Result<std::vector<std::byte>> encode_exr(const ExrPicture& picture, std::vector<std::byte> room = {});

// Any pixel type becomes float; values are the file's own, NaN and Inf included. `name` is for messages.
// Errors: Corrupt (no OpenEXR, damaged), Truncated, Unsupported (deep, subsampled or above 2^29 samples).
Result<ExrImage> decode_exr(std::span<const std::byte> bytes, const std::string& name);
Result<ExrImage> read_exr(Storage& storage, const std::string& path);
// Without decoding the picture.
Result<ExrAttributes> read_exr_attributes(Storage& storage, const std::string& path);

}  // namespace hdrcam
