// Bytes as text of 64 characters (RFC 4648), to put a file into a page. Reentrant.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace hdrcam {

std::string base64(std::span<const std::byte> bytes);  // with padding

}  // namespace hdrcam
