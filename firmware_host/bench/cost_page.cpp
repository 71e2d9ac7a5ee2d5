#include "firmware_host/bench/cost_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "firmware_host/sinks/report_style.h"
#include "firmware_host/sinks/svg_chart.h"
#include "firmware_host/version.h"
#include "hal/core/counted.h"
#include "hal/core/cpu.h"
#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

std::vector<PointCost> by_time(std::vector<PointCost> points) {
  std::ranges::stable_sort(points, {}, &PointCost::mean_ms);
  return points;
}

// A score that is not finite becomes null in the text.
Json json_of(const PointCost& cost) {
  return {{"point", cost.point},
          {"group", cost.group},
          {"clip", cost.clip},
          {"frames", cost.frames},
          {"ms_per_frame", cost.mean_ms},
          {"p95_ms", cost.p95_ms},
          {"psnr_mu", cost.psnr_mu_db},
          {"worst_psnr_mu", cost.worst_psnr_mu_db},
          {"flicker", cost.flicker_stops}};
}

std::vector<std::string> groups_of(std::span<const PointCost> points) {
  std::vector<std::string> groups;
  for (const PointCost& point : points)
    if (std::ranges::find(groups, point.group) == groups.end()) groups.push_back(point.group);
  return groups;
}

// One score of the points against their time, a colour for each knob.
std::string chart_of(std::span<const PointCost> points, const char* label, const char* unit,
                     double PointCost::*score) {
  Chart chart;
  chart.label = label, chart.x_label = "ms per frame", chart.y_label = unit;
  std::vector<std::string> names;
  for (const PointCost& point : points) chart.x.push_back(point.mean_ms), names.push_back(point.point);
  const std::vector<std::string> groups = groups_of(points);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    ChartSeries series;
    series.name = groups[g], series.colour = series_colour(g);
    for (const PointCost& point : points)
      series.y.push_back(point.group == groups[g] ? point.*score : std::numeric_limits<double>::quiet_NaN());
    chart.series.push_back(std::move(series));
  }
  return fmt::format("<div class=\"card\"><h2>{}</h2>{}</div>\n", escaped(label),
                     marked_points(chart, names));
}

}  // namespace

std::vector<bool> on_the_front(std::span<const PointCost> points) {
  std::vector<bool> front;
  for (const PointCost& point : points)
    front.push_back(std::ranges::none_of(points, [&](const PointCost& other) {
      return other.mean_ms < point.mean_ms && other.psnr_mu_db >= point.psnr_mu_db;
    }));
  return front;
}

std::string cost_table(std::span<const PointCost> costs) {
  const std::vector<PointCost> means = by_time(means_of(costs));
  const std::vector<bool> front = on_the_front(means);
  std::string text =
      "| point | ms per frame | p95 ms | PSNR-mu dB | worst frame dB | flicker stops | on the front |\n"
      "|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < means.size(); ++i) {
    const PointCost& m = means[i];
    const std::string flicker = std::isfinite(m.flicker_stops) ? fmt::format("{:.4f}", m.flicker_stops) : "-";
    text += fmt::format("| {} | {:.1f} | {:.1f} | {:.2f} | {:.2f} | {} | {} |\n", m.point, m.mean_ms,
                        m.p95_ms, m.psnr_mu_db, m.worst_psnr_mu_db, flicker, front[i] ? "yes" : "");
  }
  return text;
}

std::string cost_json(const MeasuredWalk& walk) {
  Json json{{"hdrcam", kVersion},
            {"command", walk.command},
            {"threads", walk.threads},
            {"cpu", cpu_model()},
            {"instruction_set", name(instruction_set())}};
  for (const PointCost& mean : by_time(means_of(walk.costs))) json["means"].push_back(json_of(mean));
  for (const PointCost& cost : walk.costs) json["points"].push_back(json_of(cost));
  return json_text(json, 2) + "\n";
}

std::string cost_page(const MeasuredWalk& walk) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>The cost of accuracy "
      "- hdrcam</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n<header><h1>The cost of accuracy</h1>\n"
      "<p>{}, {}, {}. <code>{}</code></p></header>\n",
      kReportStyle, escaped(cpu_model()), name(instruction_set()), counted(walk.threads, "thread"),
      escaped(walk.command));
  std::vector<PointCost> shown = means_of(walk.costs);
  const auto section = [&](const std::string& title) {
    html += fmt::format("<section><h2>{}</h2>\n", escaped(title));
    html += chart_of(shown, "Quality", "PSNR-mu, dB", &PointCost::psnr_mu_db);
    html += chart_of(shown, "Flicker", "stops per frame", &PointCost::flicker_stops);
    html += "</section>\n";
  };
  section("Mean of the clips");
  std::vector<std::string> clips;
  for (const PointCost& cost : walk.costs)
    if (std::ranges::find(clips, cost.clip) == clips.end()) clips.push_back(cost.clip);
  for (const std::string& clip : clips) {
    shown.clear();
    std::ranges::copy_if(walk.costs, std::back_inserter(shown),
                         [&](const PointCost& cost) { return cost.clip == clip; });
    section(clip);
  }
  return html + fmt::format("<footer>hdrcam {}</footer>\n</main>\n</body>\n</html>\n", kVersion);
}

}  // namespace hdrcam
