// Whether FFmpeg would decode a TIFF to other codes than the file holds. It reads strips of unsigned codes;
// of tiles, JPEG inside, signed codes and floating point of 16 bits it makes a picture all the same, and says
// nothing. Reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace hdrcam {

// file: all of it, of either byte order. nullopt, or a clause that goes on after the name of the file and
// says what to do. What is no TIFF, or is damaged, is left to the decoder.
std::optional<std::string> objection_to_tiff(std::span<const std::uint8_t> file);

}  // namespace hdrcam
