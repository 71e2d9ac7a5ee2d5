// The names of sinks: the keys of their paths in the settings (output.NAME), and what statistics call them.
#pragma once

#include <string_view>

namespace hdrcam::sink_name {

inline constexpr std::string_view kFrames = "frames", kVideo = "video", kPreview = "preview",
                                  kSheet = "sheet", kStats = "stats", kReport = "report", kHttp = "http";
// For other tools.
inline constexpr std::string_view kFlowForward = "flow_forward", kFlowBackward = "flow_backward",
                                  kFieldFlowForward = "field_flow_forward",
                                  kFieldFlowBackward = "field_flow_backward", kDepth = "depth",
                                  kTransforms = "transforms", kColmap = "colmap";

}  // namespace hdrcam::sink_name
