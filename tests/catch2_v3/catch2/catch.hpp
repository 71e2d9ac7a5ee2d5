// The header and the names of Catch2 2 (Debian 12), where version 3 is installed (Debian 13, Ubuntu 24.04).
#pragma once

#include <catch2/catch_all.hpp>

#include <string>

namespace Catch {

using Matchers::EndsWith;
using Matchers::Equals;
using Matchers::Matches;
using Matchers::StartsWith;
using TestEventListenerBase = EventListenerBase;

// In version 3 this name asks for an element of a range.
inline auto Contains(const std::string& part) { return Matchers::ContainsSubstring(part); }

}  // namespace Catch

using Catch::Approx;
