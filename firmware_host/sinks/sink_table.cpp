#include "firmware_host/sinks/sink_table.h"

#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/report.h"
#include "firmware_host/sinks/stats.h"

namespace hdrcam {
namespace {

using Opened = Result<std::unique_ptr<FrameSink>>;

Opened open_frames(const SinkRequest& request) {
  ExrSequenceOptions options;
  options.layers = request.layers;
  options.compression = request.compression;
  options.framerate_hz = request.camera.framerate_hz;
  return create_exr_sequence(request.storage, request.path, options);
}

constexpr SinkKind kSinkKinds[] = {
    {"frames", "-o,--output", "HDR frames, numbered by the sensor's sequence: out/%06d.exr",
     SinkPace::Complete, open_frames},
    {"preview", "--preview", "tone-mapped pictures: out/%06d.png", SinkPace::Latest,
     [](const SinkRequest& request) { return create_preview(request.storage, request.path); }},
    {"sheet", "--sheet", "contact sheet of the run: sheet.png", SinkPace::Latest,
     [](const SinkRequest& request) { return create_contact_sheet(request.storage, request.path); }},
    {"stats", "--stats", "time, losses and provenance per frame: stats.json", SinkPace::Light,
     [](const SinkRequest& request) { return create_stats(request.storage, request.path); }},
    {"report", "--report", "all of that on one page: report.html", SinkPace::Latest,
     [](const SinkRequest& request) { return create_report(request.storage, request.path); }},
};

}  // namespace

std::span<const SinkKind> sink_kinds() { return kSinkKinds; }

}  // namespace hdrcam
