// The version of this build, from project(... VERSION) in the top-level CMakeLists.txt.
#pragma once

#ifndef HDRCAM_VERSION
#error "firmware_host/CMakeLists.txt defines HDRCAM_VERSION"
#endif

namespace hdrcam {

constexpr const char* kVersion = HDRCAM_VERSION;
constexpr const char* kReleased = "2026-11-22";  // the day of that version, on the manual pages

}  // namespace hdrcam
