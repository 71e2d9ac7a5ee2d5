// Whether the colour profile of a picture (ICC.1:2010) states other primaries than those of BT.709 and sRGB,
// as Display P3 and Adobe RGB do. Reentrant.
#pragma once

#include <cstdint>
#include <span>

namespace hdrcam {

// profile: all of it. False where it states no primaries, as profiles of grey or with tables, or is damaged.
bool states_other_primaries(std::span<const std::uint8_t> profile);

}  // namespace hdrcam
