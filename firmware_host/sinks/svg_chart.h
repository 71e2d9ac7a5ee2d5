// Charts as SVG elements to embed in HTML: axes with round ticks, units in the labels, a legend. Text and
// grid take the colours of the page (CSS variables --ink, --muted, --grid), so a chart is readable on light
// and dark. Reentrant.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdrcam {

// Text as HTML or SVG content or attribute value. Names of files need not be UTF-8, a page is: other bytes
// become U+FFFD.
std::string escaped(std::string_view text);

struct ChartSeries {
  std::string name;
  std::string colour;     // CSS
  std::vector<double> y;  // as many as x; a value that is not finite is a gap
  bool dashed = false;
};

struct ChartLimit {  // a horizontal line to compare with
  std::string name;
  double y = 0;
};

struct Chart {
  std::string label;  // the chart's text for screen readers
  std::string x_label, y_label;
  std::vector<double> x;  // increasing, except for marked_points()
  std::vector<ChartSeries> series;
  std::optional<ChartLimit> limit;
  bool logarithmic_y = false;             // powers of ten; values <= 0 are gaps
  std::optional<double> y_least, y_most;  // of the axis; otherwise from the values
};

std::string line_chart(const Chart& chart);
// One bar per x, the series on top of each other in their order. Ignores logarithmic_y.
std::string stacked_bars(const Chart& chart);

// A mark for each value, with names[i] beside the marks at x[i]; no lines.
std::string marked_points(const Chart& chart, const std::vector<std::string>& names);

// Round values that divide [least, most] into about `wanted` steps of 1, 2 or 5 times a power of ten.
std::vector<double> round_ticks(double least, double most, int wanted);

// The i-th of a series of colours that are distinct on light and dark, also for colour-blind users.
std::string series_colour(std::size_t i);

}  // namespace hdrcam
