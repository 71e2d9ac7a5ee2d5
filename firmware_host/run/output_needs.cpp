#include "firmware_host/run/output_needs.h"

#include <fmt/format.h>

namespace hdrcam {

OutputNeeds needs_of(const Settings::Output& output) {
  const ExrLayers& layers = output.layers;
  const auto wanted = [&](const char* sink) { return !output.path(sink).empty(); };
  OutputNeeds needs;
  needs.depth = layers.depth || wanted("depth");
  needs.flow_backward = layers.flow || wanted("flow_backward");
  needs.flow_forward = layers.flow_forward || wanted("flow_forward");
  needs.field_flow = layers.field_flow || layers.field_flow_forward || wanted("field_flow_forward") ||
                     wanted("field_flow_backward");
  needs.poses = wanted("transforms") || wanted("colmap");
  needs.points = wanted("colmap");
  return needs;
}

ExrCompression compression_of(const Settings::Output& output, RunPace pace) {
  switch (output.compression) {
    case FrameCompression::None:
      return ExrCompression::None;
    case FrameCompression::Rle:
      return ExrCompression::Rle;
    case FrameCompression::Zip:
      return ExrCompression::Zip;
    case FrameCompression::Piz:
      return ExrCompression::Piz;
    case FrameCompression::Auto:
      break;
  }
  return pace == RunPace::Camera ? ExrCompression::None : kUsualCompression;
}

Result<void> check_needs(const Settings& settings) {
  if (needs_of(settings.output).flow_forward && settings.fit.lookahead == 0)
    return Error{ErrorCode::Invalid,
                 "motion to the next frame is known once that frame is there; give --lookahead 1"};
  for (const char* sink : {"depth", "field_flow_forward", "field_flow_backward"})
    if (!settings.output.path(sink).empty() && settings.fit.emit == EmitLayer::State)
      return Error{
          ErrorCode::Invalid,
          fmt::format("'{}' comes from the field, which --emit state leaves out; leave out one of them",
                      settings.output.path(sink))};
  return {};
}

}  // namespace hdrcam
