// report.html: a run on one self-contained page (styles, charts and pictures are inside; no script, no
// network), readable on light and dark screens and on paper. The sink is thread-bound.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// contact_sheet_png: ContactSheet::png(), or empty for a report without it. Long runs are averaged over
// consecutive frames for the charts, so the page stays small. Reentrant.
std::string report_html(const RunRecord& record, std::span<const std::byte> contact_sheet_png);

// Writes the page when the run is concluded, with its own contact sheet; creates the folder. The storage
// outlives the sink.
Result<std::unique_ptr<FrameSink>> create_report(Storage& storage, const std::string& path);

}  // namespace hdrcam
