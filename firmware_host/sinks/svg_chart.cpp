#include "firmware_host/sinks/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

// The picture in user units; the page scales it to its column.
constexpr double kWidth = 560, kHeight = 250;
constexpr double kLeft = 70, kRight = 14, kTop = 12, kBottom = 44;
constexpr double kBarGap = 0.12;  // of a bar's width
// Of texts: ticks from their axis, and from the middle of a line to its baseline; labels from the picture's
// border; the name of a line above it, of a mark beside it.
constexpr double kTickLeft = 7, kTickDown = 17, kHalfText = 4;
constexpr double kLabelLeft = 14, kLabelUp = 7;
constexpr double kNameUp = 5, kNameRight = 6, kLimitNameLeft = 4;
constexpr double kMarkRadius = 4;

struct Range {
  double least = 0, most = 1;
};

// From data to user units.
struct Frame {
  Range x, y;
  bool logarithmic_y = false;

  double right_of(double value) const {
    return kLeft + (value - x.least) / (x.most - x.least) * (kWidth - kLeft - kRight);
  }
  double height_of(double value) const {
    const double place =
        logarithmic_y ? (std::log10(value) - std::log10(y.least)) / (std::log10(y.most) - std::log10(y.least))
                      : (value - y.least) / (y.most - y.least);
    return kHeight - kBottom - std::clamp(place, -0.02, 1.02) * (kHeight - kTop - kBottom);
  }
};

enum class Scale { Linear, Logarithmic };

Scale vertical_scale(const Chart& chart) { return chart.logarithmic_y ? Scale::Logarithmic : Scale::Linear; }

bool shown(double value, Scale scale) {
  return std::isfinite(value) && (scale == Scale::Linear || value > 0);
}

Range range_of(const std::vector<double>& values, Scale scale) {
  const bool logarithmic = scale == Scale::Logarithmic;
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double value : values) {
    if (!shown(value, scale)) continue;
    range.least = std::min(range.least, value);
    range.most = std::max(range.most, value);
  }
  if (!(range.least <= range.most)) return logarithmic ? Range{0.1, 1} : Range{0, 1};
  if (logarithmic)
    return {std::pow(10, std::floor(std::log10(range.least))),
            std::pow(10, std::ceil(std::log10(range.most) + 1e-9))};
  if (range.least == range.most) range.most = range.least + 1;
  return range;
}

// The vertical range: as the chart sets it, otherwise from the values with a small margin above.
Range vertical_range(const Chart& chart, const std::vector<double>& values) {
  constexpr double kAir = 0.04;
  Range range = range_of(values, vertical_scale(chart));
  if (!chart.logarithmic_y) range.most += kAir * (range.most - range.least);
  return {chart.y_least.value_or(range.least), chart.y_most.value_or(range.most)};
}

// Of all series.
std::vector<double> values_of(const Chart& chart) {
  std::vector<double> values;
  for (const ChartSeries& series : chart.series)
    values.insert(values.end(), series.y.begin(), series.y.end());
  return values;
}

std::vector<double> vertical_ticks(const Frame& frame) {
  if (!frame.logarithmic_y) return round_ticks(frame.y.least, frame.y.most, 5);
  std::vector<double> ticks;
  const int first = static_cast<int>(std::lround(std::log10(frame.y.least)));
  const int last = static_cast<int>(std::lround(std::log10(frame.y.most)));
  const int step = std::max(1, (last - first) / 6);
  for (int power = first; power <= last; power += step) ticks.push_back(std::pow(10, power));
  return ticks;
}

// Of all series at each x.
std::vector<double> totals_of(const Chart& chart) {
  std::vector<double> totals(chart.x.size(), 0.0);
  for (const ChartSeries& series : chart.series)
    for (std::size_t i = 0; i < totals.size(); ++i)
      if (shown(series.y[i], Scale::Linear)) totals[i] += series.y[i];
  return totals;
}

std::string opened(const Chart& chart) {
  return fmt::format("<figure class=\"chart\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n",
                     kWidth, kHeight, escaped(chart.label));
}

std::string axes(const Chart& chart, const Frame& frame) {
  std::string svg;
  auto out = std::back_inserter(svg);
  const double bottom = kHeight - kBottom;
  for (const double tick : vertical_ticks(frame)) {
    const double y = frame.height_of(tick);
    fmt::format_to(out, "<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>", kLeft,
                   kWidth - kRight, y, y);
    fmt::format_to(out, "<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>\n", kLeft - kTickLeft,
                   y + kHalfText, tick);
  }
  for (const double tick : round_ticks(frame.x.least, frame.x.most, 8)) {
    const double x = frame.right_of(tick);
    fmt::format_to(out, "<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:.6g}</text>", x,
                   bottom + kTickDown, tick);
  }
  fmt::format_to(out, "\n<line class=\"axis\" x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\"/>", kLeft,
                 kWidth - kRight, bottom);
  fmt::format_to(out, "<text class=\"unit\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                 (kLeft + kWidth - kRight) / 2, kHeight - kLabelUp, escaped(chart.x_label));
  const double middle = (kTop + bottom) / 2;
  fmt::format_to(out,
                 "<text class=\"unit\" x=\"{2}\" y=\"{0}\" text-anchor=\"middle\" transform=\"rotate(-90 {2} "
                 "{0})\">{1}</text>\n",
                 middle, escaped(chart.y_label), kLabelLeft);
  return svg;
}

std::string limit_line(const Chart& chart, const Frame& frame) {
  if (!chart.limit || chart.limit->y > frame.y.most) return "";
  const double y = frame.height_of(chart.limit->y);
  return fmt::format(
      "<line class=\"limit\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>"
      "<text class=\"limit\" x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
      kLeft, kWidth - kRight, y, y, kWidth - kRight - kLimitNameLeft, y - kNameUp,
      escaped(chart.limit->name));
}

std::string legend(const Chart& chart) {
  std::string html = "<figcaption class=\"legend\">";
  for (const ChartSeries& series : chart.series)
    html += fmt::format("<span><i class=\"{}\" style=\"--c:{}\"></i>{}</span>",
                        series.dashed ? "dashed" : "solid", series.colour, escaped(series.name));
  return html + "</figcaption>";
}

std::string closed(const Chart& chart) { return "</svg>" + legend(chart) + "</figure>\n"; }

}  // namespace

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : as_utf8<nlohmann::json>(text)) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::vector<double> round_ticks(double least, double most, int wanted) {
  if (!(most > least) || !std::isfinite(most - least)) return {least};
  const double rough = (most - least) / wanted;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= rough * 0.999) step = factor * power;
  std::vector<double> ticks;
  const auto first = static_cast<long long>(std::ceil(least / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(most / step + 1e-9));
  for (long long i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

std::string series_colour(std::size_t i) {
  constexpr std::array kColours{"#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1", "#76b7b2",
                                "#edc948", "#9c755f", "#ff9da7", "#8c8c8c", "#5b6cc9", "#a0508f"};
  return kColours[i % kColours.size()];
}

std::string line_chart(const Chart& chart) {
  std::vector<double> values = values_of(chart);
  if (chart.limit) values.push_back(chart.limit->y);
  const Frame frame{range_of(chart.x, Scale::Linear), vertical_range(chart, values), chart.logarithmic_y};
  std::string svg = opened(chart) + axes(chart, frame);
  auto out = std::back_inserter(svg);
  for (const ChartSeries& series : chart.series) {
    std::string path;
    bool pen_down = false;
    for (std::size_t i = 0; i < series.y.size(); ++i) {
      const bool visible = shown(series.y[i], vertical_scale(chart));
      if (visible)
        fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", pen_down ? "L" : "M",
                       frame.right_of(chart.x[i]), frame.height_of(series.y[i]));
      pen_down = visible;
    }
    fmt::format_to(out, "<path class=\"{}\" stroke=\"{}\" d=\"{}\"><title>{}</title></path>\n",
                   series.dashed ? "dashed" : "solid", series.colour, path, escaped(series.name));
  }
  return svg + limit_line(chart, frame) + closed(chart);
}

std::string marked_points(const Chart& chart, const std::vector<std::string>& names) {
  constexpr double kAir = 0.08;  // of the range, to the left and right of the marks
  Range across = range_of(chart.x, Scale::Linear);
  const double air = kAir * (across.most - across.least);
  across.least -= air, across.most += air;
  const Frame frame{across, vertical_range(chart, values_of(chart)), chart.logarithmic_y};
  std::string svg = opened(chart) + axes(chart, frame);
  auto out = std::back_inserter(svg);
  for (const ChartSeries& series : chart.series)
    for (std::size_t i = 0; i < series.y.size(); ++i) {
      if (!shown(series.y[i], vertical_scale(chart))) continue;
      const double x = frame.right_of(chart.x[i]), y = frame.height_of(series.y[i]);
      fmt::format_to(out, "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>", x, y, kMarkRadius,
                     series.colour);
      fmt::format_to(out, "<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + kNameRight, y - kNameUp,
                     escaped(names[i]));
    }
  return svg + closed(chart);
}

std::string stacked_bars(const Chart& chart) {
  std::vector<double> values = totals_of(chart);
  values.push_back(0);
  if (chart.limit) values.push_back(chart.limit->y);
  const double spacing =
      chart.x.size() > 1 ? (chart.x.back() - chart.x.front()) / static_cast<double>(chart.x.size() - 1) : 1;
  const double first = chart.x.empty() ? 0 : chart.x.front(), last = chart.x.empty() ? 1 : chart.x.back();
  const Frame frame{{first - spacing / 2, last + spacing / 2}, vertical_range(chart, values), false};

  std::string svg = opened(chart) + axes(chart, frame);
  auto out = std::back_inserter(svg);
  const double width = spacing * (1 - kBarGap);
  std::vector<double> base(chart.x.size(), 0.0);
  for (const ChartSeries& series : chart.series) {
    fmt::format_to(out, "<path fill=\"{}\" d=\"", series.colour);
    for (std::size_t i = 0; i < chart.x.size(); ++i) {
      if (!shown(series.y[i], Scale::Linear) || series.y[i] <= 0) continue;
      const double left = frame.right_of(chart.x[i] - width / 2),
                   right = frame.right_of(chart.x[i] + width / 2);
      const double low = frame.height_of(base[i]), high = frame.height_of(base[i] + series.y[i]);
      fmt::format_to(out, "M{:.1f} {:.1f}V{:.1f}H{:.1f}V{:.1f}Z", left, low, high, right, low);
      base[i] += series.y[i];
    }
    fmt::format_to(out, "\"><title>{}</title></path>\n", escaped(series.name));
  }
  return svg + limit_line(chart, frame) + closed(chart);
}

}  // namespace hdrcam
