// Camera and frame facts as JSON text, sealed with a checksum (docs/recording.md). Doubles are read back bit
// by bit; a number that is not finite becomes null and is read back as NaN. Reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/recording/recording.h"

namespace hdrcam {

// One packet of the facts track: the facts of a frame, or the end record.
struct FactsRecord {
  bool is_end = false;
  std::uint64_t index = 0;  // of the frame; in the end record the number of frames
  FrameFacts facts;         // of the frame
};

// codec: of the pixels beside them, which decides the version of the format.
std::string to_json(const CameraFacts& camera, RecordingCodec codec);
// bits: of a code, for the black level.
std::string to_json(std::uint64_t index, const FrameFacts& facts, int bits);
std::string end_record_json(std::uint64_t frames);

// Errors: Corrupt where a fact is missing or impossible; Unsupported for a newer format.
Result<CameraFacts> camera_from_json(std::string_view text);
Result<FactsRecord> record_from_json(std::string_view text, int bits);

std::optional<PixelLayout> layout_named(std::string_view name);
std::optional<ExposureSource> exposure_source_named(std::string_view name);
std::optional<Verdict> verdict_named(std::string_view name);

// Appends `"crc32"` to a JSON object: the checksum over the payload, then over the text before.
std::string seal(const std::string& json_object, std::span<const std::uint8_t> payload);
// Whether text is a sealed object, and payload and text are unchanged since it was sealed.
bool seal_holds(std::string_view sealed, std::span<const std::uint8_t> payload);

}  // namespace hdrcam
