// The style sheet of report.html, and of the page of `hdrcam bench pareto`.
#pragma once

namespace hdrcam {

inline constexpr const char* kReportStyle = R"css(
:root { color-scheme: light dark;
  --paper: #fbfbfa; --card: #ffffff; --ink: #1d2126; --muted: #667079; --grid: #e4e6e8; --line: #d9dcdf;
  --accent: #2563a8; --good: #2f7d3b; --bad: #c0392b; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #131518; --card: #1b1e22; --ink: #e4e7ea; --muted: #98a1aa; --grid: #2b3036; --line: #30353b;
  --accent: #7db3ea; --good: #7cc487; --bad: #f0776a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 36px 24px 64px; }
header h1 { margin: 0; font-size: 27px; letter-spacing: -0.01em; }
header p { margin: 4px 0 0; color: var(--muted); }
code { font: 13px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace; overflow-wrap: anywhere; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(132px, 1fr)); gap: 12px; margin: 24px 0 8px; }
.tile { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 12px; }
.tile b { display: block; white-space: nowrap; font-size: 20px; font-weight: 600; font-variant-numeric: tabular-nums; }
.tile b small { font-size: 13px; font-weight: 500; color: var(--muted); }
.tile span { color: var(--muted); font-size: 13px; }
section { margin-top: 34px; }
h2 { font-size: 17px; margin: 0 0 4px; }
section > p { margin: 0 0 12px; color: var(--muted); max-width: 78ch; }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 16px; }
.sheet img { display: block; width: 100%; border-radius: 6px; }
.chart { margin: 0 auto; max-width: 680px; }
.chart svg { display: block; width: 100%; height: auto; }
.chart text { fill: var(--muted); font-size: 12px; font-variant-numeric: tabular-nums; }
.chart text.limit { fill: var(--bad); }
.chart line.grid { stroke: var(--grid); }
.chart line.axis { stroke: var(--muted); }
.chart line.limit { stroke: var(--bad); stroke-width: 1.5; stroke-dasharray: 6 4; }
.chart path.solid { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
.chart path.dashed { fill: none; stroke-width: 1.8; stroke-dasharray: 5 4; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 18px; margin-top: 6px; font-size: 13px; color: var(--muted); }
.legend i { display: inline-block; width: 20px; height: 0; margin-right: 7px; vertical-align: middle;
  border-top: 4px solid var(--c); border-radius: 2px; }
.legend i.dashed { border-top: 2px dashed var(--c); }
table { width: 100%; border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 6px 12px 6px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
tr:last-child th, tr:last-child td { border-bottom: 0; }
thead th { color: var(--muted); font-weight: 500; font-size: 13px; }
tbody th { font-weight: 500; }
td.n, th.n { text-align: right; }
.good { color: var(--good); } .bad { color: var(--bad); }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(460px, 100%), 1fr)); gap: 16px; }
ul { margin: 0; padding-left: 18px; }
footer { margin-top: 40px; color: var(--muted); font-size: 13px; }
@media print { body { background: none; } .card, .tile { break-inside: avoid; } }
)css";

}  // namespace hdrcam
