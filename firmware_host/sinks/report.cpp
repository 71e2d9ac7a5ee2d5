#include "firmware_host/sinks/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "firmware_host/base64.h"
#include "firmware_host/percent_text.h"
#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/sinks/report_style.h"
#include "firmware_host/sinks/svg_chart.h"
#include "firmware_host/version.h"
#include "firmware_host/whole_percent.h"
#include "hal/core/counted.h"
#include "hal/core/cpu.h"

namespace hdrcam {
namespace {

constexpr std::size_t kMostPoints = 240;  // along a chart's time axis
constexpr std::size_t kMostNotedFrames = 20;
// % of frames within the deadline; from here on the share is shown in green
constexpr std::uint64_t kMetWell = 95;
constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

std::string css(Rgb colour) { return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b); }

std::string section(const char* title, const std::string& explanation, const std::string& content) {
  return fmt::format("<section><h2>{}</h2>\n<p>{}</p>\n{}</section>\n", title, explanation, content);
}

std::string card(const std::string& content) { return "<div class=\"card\">" + content + "</div>\n"; }

std::string tile(const std::string& value, const std::string& unit, const std::string& meaning,
                 const char* look = "") {
  return fmt::format("<div class=\"tile\"><b class=\"{}\">{} <small>{}</small></b><span>{}</span></div>\n",
                     look, escaped(value), escaped(unit), escaped(meaning));
}

// head: the cells of its first row; rows: whole rows.
std::string table(const std::string& head, const std::string& rows) {
  return "<table><thead><tr>" + head + "</tr></thead><tbody>" + rows + "</tbody></table>";
}

std::string fact(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
}

// Means over consecutive frames, so that at most kMostPoints remain; missing values do not count.
std::vector<double> averaged(const std::vector<double>& values) {
  const std::size_t width = (values.size() + kMostPoints - 1) / kMostPoints;
  if (width <= 1) return values;
  std::vector<double> means;
  for (std::size_t first = 0; first < values.size(); first += width) {
    double sum = 0, count = 0;
    for (std::size_t i = first; i < std::min(first + width, values.size()); ++i)
      if (std::isfinite(values[i])) sum += values[i], count += 1;
    means.push_back(count > 0 ? sum / count : kHole);
  }
  return means;
}

std::vector<double> over_frames(const RunRecord& record,
                                const std::function<double(const FrameRecord&)>& value) {
  std::vector<double> values;
  values.reserve(record.frames.size());
  for (const FrameRecord& frame : record.frames) values.push_back(value(frame));
  return averaged(values);
}

// absent: where no value has that name
double value_named(const FrameValues& values, const std::string& wanted, double absent) {
  for (const NamedValue& entry : values)
    if (entry.name == wanted) return entry.value;
  return absent;
}

// The names in the order in which they first occur in any frame.
std::vector<std::string> names_in(const RunRecord& record, FrameValues FrameRecord::*list) {
  std::vector<std::string> names;
  for (const FrameRecord& frame : record.frames)
    for (const NamedValue& entry : frame.*list)
      if (std::find(names.begin(), names.end(), entry.name) == names.end()) names.emplace_back(entry.name);
  return names;
}

// A chart of values over the frames of a run, still without series.
Chart frame_chart(const RunRecord& record, const char* label, const char* y_label) {
  Chart chart;
  chart.label = label;
  chart.x_label = "frame (sensor sequence)";
  chart.y_label = y_label;
  chart.x = over_frames(record, [](const FrameRecord& frame) { return static_cast<double>(frame.sequence); });
  return chart;
}

// absent: what a frame without a value has
std::vector<ChartSeries> series_of(const RunRecord& record, FrameValues FrameRecord::*list, double absent) {
  std::vector<ChartSeries> series;
  for (const std::string& name : names_in(record, list))
    series.push_back({name, series_colour(series.size()), over_frames(record, [&](const FrameRecord& frame) {
                        return value_named(frame.*list, name, absent);
                      })});
  return series;
}

std::string tiles(const RunRecord& record) {
  const double mean_ms = mean_ms_per_frame(record);
  std::string html = "<div class=\"tiles\">\n";
  html += tile(fmt::format("{}", record.emitted), "", "HDR frames emitted");
  html += tile(fmt::format("{:.1f}", mean_ms), "ms",
               mean_ms > 0 ? fmt::format("per frame, {:.1f} frames/s", 1000 / mean_ms) : "per frame");
  if (const int worked_on = record.emitted + record.left_out; record.deadline_ms > 0 && worked_on > 0) {
    const std::uint64_t share =
        whole_percent(static_cast<std::uint64_t>(std::max(0, worked_on - record.late)),
                      static_cast<std::uint64_t>(worked_on));
    html += tile(fmt::format("{}", share), "%", fmt::format("of frames within {:.1f} ms", record.deadline_ms),
                 share < kMetWell ? "bad" : "good");
  }
  html += tile(fmt::format("{}", record.dropped), "", "frames dropped", record.dropped > 0 ? "bad" : "");
  for (const bool higher_is_better : {true, false}) {  // the first score of each kind
    const auto score = std::find_if(record.scores.begin(), record.scores.end(), [&](const ScoreRow& row) {
      return row.higher_is_better == higher_is_better;
    });
    if (score != record.scores.end())
      html += tile(fmt::format("{:.4g}", score->value), score->unit, score->name);
  }
  if (record.peak_memory_mib > 0)
    html += tile(fmt::format("{:.0f}", record.peak_memory_mib), "MiB", "peak memory");
  return html + "</div>\n";
}

std::string sheet_section(std::span<const std::byte> png) {
  if (png.empty()) return "";
  return section(
      "Frames",
      "Input, HDR frame and the source of each pixel, at moments spread over the clip. Depth, where it is "
      "shown, is coarse unless --depth or --layers depth asks for it.",
      fmt::format(
          "<div class=\"card sheet\"><img alt=\"contact sheet\" src=\"data:image/png;base64,{}\"></div>\n",
          base64(png)));
}

std::string scores_section(const RunRecord& record) {
  if (record.scores.empty()) return "";
  std::string rows;
  for (const ScoreRow& score : record.scores)
    rows += fmt::format("<tr><th>{}</th><td class=\"n\">{:.4g} {}</td><td>{}</td></tr>\n",
                        escaped(score.name), score.value, escaped(score.unit),
                        score.higher_is_better ? "higher is better" : "lower is better");
  return section("Scores", "Against ground truth, after one gain per channel for the whole clip.",
                 card("<table><tbody>" + rows + "</tbody></table>"));
}

std::string time_section(const RunRecord& record) {
  Chart chart = frame_chart(record, "time per frame by stage", "ms per frame");
  chart.series = series_of(record, &FrameRecord::stages_ms, 0);  // a stage that did not run took no time
  chart.y_least = 0;
  if (record.deadline_ms > 0)
    chart.limit = ChartLimit{fmt::format("deadline {:.1f} ms", record.deadline_ms), record.deadline_ms};
  std::string rows;
  for (const StageSummary& stage : stage_summaries(record))
    rows += fmt::format(
        "<tr><th>{}</th><td class=\"n\">{}</td><td class=\"n\">{:.2f}</td><td class=\"n\">{:.2f}</td>"
        "<td class=\"n\">{:.2f}</td></tr>\n",
        escaped(stage.name), stage.frames, stage.mean_ms, stage.p95_ms, stage.max_ms);
  const char* const head =
      "<th>stage</th><th class=\"n\">frames</th><th class=\"n\">mean, ms</th>"
      "<th class=\"n\">95th percentile, ms</th><th class=\"n\">longest, ms</th>";
  return section("Time", "Time per frame, by stage.",
                 "<div class=\"two\">" + card(stacked_bars(chart)) + card(table(head, rows)) + "</div>\n");
}

// What the governor gave up to hold the deadline: over time, and for how many frames.
std::string deadline_section(const RunRecord& record) {
  if (record.rungs.empty()) return "";
  Chart chart = frame_chart(record, "rung of quality over time", "rung (0: as asked)");
  chart.series.push_back({"rung", series_colour(0), over_frames(record, [](const FrameRecord& frame) {
                            return static_cast<double>(frame.rung);
                          })});
  chart.y_least = 0, chart.y_most = static_cast<double>(record.rungs.size()) - 1;
  std::string rows;
  for (std::size_t r = 0; r < record.rungs.size(); ++r)
    rows += fmt::format("<tr><td class=\"n\">{}</td><th>{}</th><td class=\"n\">{}</td></tr>\n", r,
                        escaped(record.rungs[r].name), record.rungs[r].frames);
  const char* const head = "<th class=\"n\">rung</th><th>gives up</th><th class=\"n\">frames</th>";
  return section("Deadline",
                 fmt::format("Quality given up to finish each frame within {:.1f} ms, each rung beyond those "
                             "before it. {} {} late, {} not emitted.",
                             record.deadline_ms, counted(record.late, "frame"),
                             record.late == 1 ? "was" : "were", record.left_out),
                 "<div class=\"two\">" + card(line_chart(chart)) + card(table(head, rows)) + "</div>\n");
}

std::string provenance_section(const RunRecord& record) {
  Chart chart = frame_chart(record, "provenance of the pixels over time", "% of the pixels");
  chart.y_least = 0, chart.y_most = 100;
  const auto shares = mean_provenance(record);
  std::string rows;
  for (std::size_t i = 0; i < kProvenances; ++i) {
    const ProvenanceLook& look = kProvenanceLooks[i];
    chart.series.push_back({look.name, css(look.colour), over_frames(record, [i](const FrameRecord& frame) {
                              return 100.0 * static_cast<double>(frame.provenance_share[i]);
                            })});
    rows +=
        fmt::format("<tr><th>{}</th><td class=\"n\">{} %</td></tr>\n", look.name, percent_text(shares[i]));
  }
  return section(
      "Sources of the pixels",
      "Each pixel's main source: this frame's own sample, earlier frames carried along the motion, a later "
      "frame, the field, or only a lower bound because it was clipped everywhere.",
      "<div class=\"two\">" + card(stacked_bars(chart)) +
          card(table("<th>source</th><th class=\"n\">mean share</th>", rows)) + "</div>\n");
}

std::string loss_section(const RunRecord& record) {
  Chart chart = frame_chart(record, "loss terms over time", "weighted loss");
  chart.series = series_of(record, &FrameRecord::losses, kHole);
  chart.logarithmic_y = true;
  if (chart.series.empty()) return "";
  return section("Fit",
                 "The terms of the field's objective, weighted, each the mean over the steps at its frame.",
                 card(line_chart(chart)));
}

std::string response_section(const RunRecord& record) {
  if (!record.response) return "";
  constexpr double kShownStops = 12;
  Chart chart;
  chart.label = "camera response";
  chart.x_label = "code (0 to 255)";
  chart.y_label = "stops below saturation";
  chart.y_least = -kShownStops, chart.y_most = 0;
  for (int code = 1; code < Response::kCodes; ++code) chart.x.push_back(code);
  const auto stops = [](const Response::Curve& curve) {
    std::vector<double> values;
    for (std::size_t code = 1; code < curve.size(); ++code) {
      const double stop = std::log2(static_cast<double>(curve[code]));
      values.push_back(stop >= -kShownStops ? stop : kHole);
    }
    return values;
  };
  const char* const names[] = {"red", "green", "blue"};
  const char* const colours[] = {"#d64545", "#3d9a4b", "#3f74c8"};
  for (std::size_t c = 0; c < 3; ++c)
    chart.series.push_back({names[c], colours[c], stops((*record.response)[c])});
  if (record.response_prior)
    chart.series.push_back({"prior mean", "#8c8c8c", stops(*record.response_prior), true});
  return section("Camera response",
                 "The exposure that each code stands for, as it was known at the end of the run.",
                 card(line_chart(chart)));
}

std::string notes_section(const RunRecord& record) {
  std::string items;
  for (const std::string& note : record.notes) items += fmt::format("<li>{}</li>\n", escaped(note));
  std::size_t noted = 0;
  for (const FrameRecord& frame : record.frames)
    if (!frame.note.empty() && noted++ < kMostNotedFrames)
      items += fmt::format("<li>frame {}: {}</li>\n", frame.sequence, escaped(frame.note));
  if (noted > kMostNotedFrames)
    items += fmt::format("<li>and {} more frames with remarks</li>\n", noted - kMostNotedFrames);
  return items.empty() ? ""
                       : section("Remarks", "Unusual events of the run.", card("<ul>" + items + "</ul>"));
}

std::string run_section(const RunRecord& record) {
  const bool balanced = record.captured == record.emitted + record.dropped;
  std::string rows =
      fmt::format("<tr><th>command</th><td><code>{}</code></td></tr>\n", escaped(record.command));
  rows += fact("preset", record.preset);
  rows += fact("seed", fmt::format("{}", record.seed));
  rows += fact("threads", fmt::format("{}", record.threads));
  rows += fact("hdrcam", kVersion);
  rows += fact("processor", fmt::format("{}, {} kernels", cpu_model(), name(instruction_set())));
  rows += fact("camera", fmt::format("{}{}{} x {} pixels, {:.4g} frames/s", record.camera,
                                     record.camera.empty() ? "" : ", ", record.width, record.height,
                                     record.framerate_hz));
  rows += fact("wall time", fmt::format("{:.2f} s", record.wall_s));
  rows += fmt::format(
      "<tr><th>frames</th><td class=\"{}\">{} captured {} {} emitted + {} dropped</td></tr>\n",
      balanced ? "" : "bad", record.captured, balanced ? "=" : "&ne;", record.emitted, record.dropped);
  return section("Run", "The settings and the machine, to repeat the run.",
                 card("<table><tbody>" + rows + "</tbody></table>"));
}

class Report : public FrameSink {
 public:
  Report(Storage& storage, std::string path)
      : storage_(storage), path_(std::move(path)), sheet_(storage, "") {}

  InputUse input_use() const override { return sheet_.input_use(); }
  Result<void> emit(const EmittedFrame& frame) override { return sheet_.emit(frame); }
  Result<void> finish() override { return sheet_.finish(); }
  Result<void> conclude(const RunRecord& record) override {
    const std::string html = report_html(record, sheet_.png());
    return write_whole(storage_, path_, std::as_bytes(std::span(html)));
  }

 private:
  Storage& storage_;
  const std::string path_;
  ContactSheet sheet_;
};

}  // namespace

std::string report_html(const RunRecord& record, std::span<const std::byte> contact_sheet_png) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0} - hdrcam</title>\n<style>{1}</style>\n</head>\n<body>\n<main>\n<header><h1>{0}</h1>\n"
      "<p>{2} x {3} pixels, {4} in, {5} out</p></header>\n",
      escaped(record.title), kReportStyle, record.width, record.height, counted(record.captured, "frame"),
      counted(record.emitted, "HDR frame"));
  html += tiles(record);
  html += sheet_section(contact_sheet_png);
  html += scores_section(record);
  if (!record.frames.empty())
    html += time_section(record) + deadline_section(record) + provenance_section(record);
  html += "<div class=\"two\">" + loss_section(record) + response_section(record) + "</div>\n";
  html += notes_section(record);
  html += run_section(record);
  html += fmt::format("<footer>hdrcam {}</footer>\n</main>\n</body>\n</html>\n", kVersion);
  return html;
}

Result<std::unique_ptr<FrameSink>> create_report(Storage& storage, const std::string& path) {
  TRY(make_folder_of(storage, path));
  return std::unique_ptr<FrameSink>(std::make_unique<Report>(storage, path));
}

}  // namespace hdrcam
