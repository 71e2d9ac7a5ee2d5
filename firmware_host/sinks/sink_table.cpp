#include "firmware_host/sinks/sink_table.h"

#include <unistd.h>

#include <algorithm>
#include <iterator>

#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/half_pipe.h"
#include "firmware_host/sinks/hdr_video.h"
#include "firmware_host/sinks/live_view/live_view.h"
#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/report.h"
#include "firmware_host/sinks/scene_files/depth_pictures.h"
#include "firmware_host/sinks/scene_files/flow_files.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/sinks/stats.h"
#include "hal/standard_output.h"

namespace hdrcam {
namespace {

using Opened = Result<std::unique_ptr<FrameSink>>;

Opened open_video(const SinkRequest& request) {
  const CameraFacts& camera = request.camera;
  if (camera.width > 0)  // known before the first frame
    TRY(check_video_size(request.video, camera.width, camera.height));
  return create_hdr_video(request.storage, request.path, camera.framerate_hz, request.video);
}

Opened open_pipe(const SinkRequest& request) {
  TRY(check_no_terminal({{std::string(sink_name::kFrames), request.path}}));
  if (request.video.pipe == PipeFormat::Half) return create_half_pipe(standard_output());
  return create_video_pipe(standard_output(), request.camera.framerate_hz, request.video);
}

Opened open_frames(const SinkRequest& request) {
  if (request.path == kStandardOutput) return open_pipe(request);
  if (video_container_of(request.path)) return open_video(request);
  ExrSequenceOptions options;
  options.layers = request.layers;
  options.compression = request.compression;
  options.framerate_hz = request.camera.framerate_hz;
  return create_exr_sequence(request.storage, request.path, options);
}

Opened open_live_view(const SinkRequest& request) {
  const LiveViewOptions options{request.http_token, request.compression, request.camera.framerate_hz,
                                request.video};
  return std::unique_ptr<FrameSink>(TRY(LiveView::open(request.path, options, request.control)));
}

constexpr SinkKind kSinkKinds[] = {
    {sink_name::kFrames, "-o,--output",
     "HDR frames, numbered by the sensor's sequence: out/%06d.exr; a video: out.mp4 (.mov, .mkv); or -, the "
     "standard output",
     SinkPace::Complete, SinkTarget::Files, open_frames, ".exr"},
    {sink_name::kVideo, "--video", "a video beside the frames: out.mp4 (.mov, .mkv)", SinkPace::Complete,
     SinkTarget::Files, open_video},
    {sink_name::kPreview, "--preview", "tone-mapped pictures: out/%06d.png", SinkPace::Latest,
     SinkTarget::Files,
     [](const SinkRequest& request) { return create_preview(request.storage, request.path); }, ".png"},
    {sink_name::kSheet, "--sheet", "contact sheet of the run: sheet.png", SinkPace::Latest, SinkTarget::Files,
     [](const SinkRequest& request) { return create_contact_sheet(request.storage, request.path); }},
    {sink_name::kStats, "--stats", "time, losses and provenance per frame: stats.json", SinkPace::Light,
     SinkTarget::Files,
     [](const SinkRequest& request) { return create_stats(request.storage, request.path); }},
    {sink_name::kFlowForward, "--flow-forward", "motion to the next frame, for flow tools: out/%06d.flo",
     SinkPace::Complete, SinkTarget::Files,
     [](const SinkRequest& request) {
       return create_flow_files(request.storage, "--flow-forward", request.path, &HdrFrame::flow_forward);
     },
     ".flo"},
    {sink_name::kFlowBackward, "--flow-backward", "motion to the previous frame: back/%06d.flo",
     SinkPace::Complete, SinkTarget::Files,
     [](const SinkRequest& request) {
       return create_flow_files(request.storage, "--flow-backward", request.path, &HdrFrame::flow);
     },
     ".flo"},
    {sink_name::kFieldFlowForward, "--field-flow-forward",
     "the field's motion to the next frame, a guess below --lookahead 2: field/%06d.flo", SinkPace::Complete,
     SinkTarget::Files,
     [](const SinkRequest& request) {
       return create_flow_files(request.storage, "--field-flow-forward", request.path,
                                &HdrFrame::field_flow_forward);
     },
     ".flo"},
    {sink_name::kFieldFlowBackward, "--field-flow-backward",
     "the field's motion to the previous frame: field_back/%06d.flo", SinkPace::Complete, SinkTarget::Files,
     [](const SinkRequest& request) {
       return create_flow_files(request.storage, "--field-flow-backward", request.path,
                                &HdrFrame::field_flow);
     },
     ".flo"},
    {sink_name::kDepth, "--depth",
     "depth in 16-bit pictures: depth/%06d.png, millimetres where poses are given, else thousandths of the "
     "tracked poses' unit",
     SinkPace::Complete, SinkTarget::Files,
     [](const SinkRequest& request) { return create_depth_pictures(request.storage, request.path); }, ".png"},
    {sink_name::kTransforms, "--transforms",
     "poses of the pictures for nerfstudio and instant-ngp, given or tracked: transforms.json",
     SinkPace::Light, SinkTarget::Files,
     [](const SinkRequest& request) {
       return create_transforms(request.storage, request.path, request.patterns);
     }},
    {sink_name::kColmap, "--colmap", "poses and points as a COLMAP text model, in this folder: colmap",
     SinkPace::Light, SinkTarget::Model,
     [](const SinkRequest& request) {
       return create_colmap(request.storage, request.path, request.patterns);
     }},
    {sink_name::kReport, "--report", "contact sheet, response, losses and times on one page: report.html",
     SinkPace::Latest, SinkTarget::Files,
     [](const SinkRequest& request) { return create_report(request.storage, request.path); }},
    {sink_name::kHttp, "--http", "the run in a browser, on this address: 127.0.0.1:8080", SinkPace::Light,
     SinkTarget::Address, open_live_view},
};

}  // namespace

std::span<const SinkKind> sink_kinds() { return kSinkKinds; }

Result<void> check_no_terminal(const OutputPaths& paths) {
  if (path_in(paths, sink_name::kFrames) != kStandardOutput || isatty(STDOUT_FILENO) == 0) return {};
  return Error{
      ErrorCode::Invalid,
      "--output - would write the bytes of frames to this terminal; pipe them into a program, such as "
      "'hdrcam .. -o - | ffplay -', or name a video"};
}

Result<std::unique_ptr<FrameSink>> open_sink(std::string_view name, const SinkRequest& request) {
  const auto* const kind = std::ranges::find(kSinkKinds, name, &SinkKind::name);
  HDRCAM_CHECK(kind != std::end(kSinkKinds));
  return kind->open(request);
}

}  // namespace hdrcam
