// Constants shared by the writer and the reader of a recording (docs/recording.md).
#pragma once

namespace hdrcam::matroska {

constexpr const char* kCameraTag = "HDRCAM_CAMERA";
constexpr int kPixelTrack = 0, kFactsTrack = 1;  // stream indices

}  // namespace hdrcam::matroska
