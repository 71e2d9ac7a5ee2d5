#include "firmware_host/film/view_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "firmware_host/settings/setting_field.h"
#include "firmware_host/settings/suggestion.h"
#include "hal/core/json_text.h"
#include "hal/core/parse_number.h"
#include "hal/core/split_text.h"

namespace hdrcam {
namespace {

constexpr double kMostLength = 1e6;      // of any unit, s too; beyond it a digit too many was typed
constexpr double kMostAngle_deg = 3600;  // ten turns
constexpr std::size_t kMostPoses = 100000;
constexpr std::string_view kAroundCells = " \t\r\n\"";
// The pose of a moment: its time, then lengths, then angles.
constexpr std::array<const char*, 7> kColumns{"time_s", "dx", "dy", "dz", "yaw", "pitch", "roll"};
constexpr std::size_t kTime = 0, kFirstLength = 1, kFirstAngle = 4;

std::optional<double> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return parse_number<double>(text);
}

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  for (const std::string_view cell : split(line, ',')) cells.emplace_back(trimmed(cell, kAroundCells));
  return cells;
}

std::size_t column_of(std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(kColumns, name) - kColumns.begin());
}

Error unknown_column(const std::string& where, const std::string& name) {
  if (name.find(';') != std::string::npos)
    return {ErrorCode::Invalid,
            fmt::format("{}: the values are separated by ';'; write commas, and points in numbers: time_s,dx",
                        where)};
  const std::vector<std::string> known(kColumns.begin(), kColumns.end());
  return {ErrorCode::Invalid,
          fmt::format("{}: unknown name '{}'{}; a pose has time_s,dx,dy,dz,yaw,pitch,roll", where, name,
                      did_you_mean(name, known))};
}

Error no_text(const std::string& path) {
  return {ErrorCode::Invalid,
          fmt::format("'{}' is not a path of views: it is not text; write CSV with a line of "
                      "names, such as time_s,dx, or JSON",
                      path)};
}

using Row = std::array<double, kColumns.size()>;

Result<void> check(const std::string& where, const Row& row) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double most = i < kFirstAngle ? kMostLength : kMostAngle_deg;
    if (std::abs(row[i]) <= most && (i != kTime || row[i] >= 0)) continue;
    return Error{ErrorCode::Invalid,
                 fmt::format("{}: {} cannot be {:g}; it is {}", where, kColumns[i], row[i],
                             i == kTime        ? "a time from 0 to 1000000 s"
                             : i < kFirstAngle ? "a length of the scene up to 1000000"
                                               : "an angle in degrees up to ten turns")};
  }
  return {};
}

ViewOffset offset_of(const Row& row) { return {{row[1], row[2], row[3]}, {row[4], row[5], row[6]}}; }

// The places in kColumns of the names in a file's first line.
Result<std::vector<std::size_t>> columns_of(const std::string& where, const std::vector<std::string>& names) {
  std::vector<std::size_t> columns;
  for (const std::string& name : names) {
    const std::size_t column = column_of(name);
    if (column == kColumns.size()) return unknown_column(where, name);
    if (std::ranges::find(columns, column) != columns.end())
      return Error{ErrorCode::Invalid, fmt::format("{}: names {} twice; name it once", where, name)};
    columns.push_back(column);
  }
  if (std::ranges::find(columns, kTime) == columns.end())
    return Error{ErrorCode::Invalid,
                 fmt::format("{}: names no time_s; each line has its time in the film, in seconds, or give "
                             "one pose by --view",
                             where)};
  return columns;
}

// One pose, of a line behind the first.
Result<Row> row_of(const std::string& where, const std::vector<std::string>& cells,
                   const std::vector<std::size_t>& columns) {
  if (cells.size() != columns.size())
    return Error{ErrorCode::Invalid, fmt::format("{}: {} values, but the first line names {}", where,
                                                 cells.size(), columns.size())};
  Row row{};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto value = number_of(cells[i]);
    if (!value)
      return Error{ErrorCode::Invalid,
                   fmt::format("{}: '{}' is not a number for {}", where, cells[i], kColumns[columns[i]])};
    row[columns[i]] = *value;
  }
  TRY(check(where, row));
  return row;
}

Result<std::vector<Row>> rows_of_csv(const std::string& path, std::string_view text) {
  std::vector<Row> rows;
  std::vector<std::size_t> columns;
  for (int line_number = 1; !text.empty() && rows.size() <= kMostPoses; ++line_number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::string where = fmt::format("{}:{}", path, line_number);
    if (const auto words = trimmed(line, kAroundCells); words.empty() || words.starts_with('#')) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (columns.empty())
      columns = TRY(columns_of(where, cells));
    else
      rows.push_back(TRY(row_of(where, cells, columns)));
  }
  return rows;
}

Result<std::vector<Row>> rows_of_json(const std::string& path, std::string_view text) {
  const auto json = parsed_json<nlohmann::json>(text);
  if (!json.is_array())
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' is not a JSON array of poses, such as [{{\"time_s\": 0, \"dx\": 0.1}}]", path)};
  if (const auto name = repeated_key<nlohmann::json>(text))
    return Error{ErrorCode::Invalid, fmt::format("{}: a pose names {} twice; name it once", path, *name)};
  std::vector<Row> rows;
  for (const auto& entry : json) {
    const std::string where = fmt::format("{}, pose {}", path, rows.size());
    if (!entry.is_object())
      return Error{ErrorCode::Invalid, where + ": is not an object with time_s, dx, .."};
    if (!entry.contains("time_s"))
      return Error{ErrorCode::Invalid, where + ": has no time_s, its time in the film in seconds"};
    Row row{};
    for (const auto& [name, value] : entry.items()) {
      const std::size_t column = column_of(name);
      if (column == kColumns.size()) return unknown_column(where, name);
      if (!value.is_number())
        return Error{ErrorCode::Invalid,
                     fmt::format("{}: '{}' is not a number for {}", where, json_text(value), name)};
      row[column] = value.get<double>();
    }
    TRY(check(where, row));
    rows.push_back(row);
    if (rows.size() > kMostPoses) break;
  }
  return rows;
}

// A value with its slope per second.
struct PathKnot {
  double value, slope;
};

// Hermite's cubic between two knots. at: 0 is a, 1 is b.
double hermite(const PathKnot& a, const PathKnot& b, double length_s, double at) {
  const double a2 = at * at, a3 = a2 * at;
  return (2 * a3 - 3 * a2 + 1) * a.value + (a3 - 2 * a2 + at) * length_s * a.slope +
         (3 * a2 - 2 * a3) * b.value + (a3 - a2) * length_s * b.slope;
}

}  // namespace

Result<SceneLength> parse_length(std::string_view flag, std::string_view text) {
  SceneLength length;
  std::string_view digits = text;
  double metres = 1;
  for (const auto& [unit, size] : {std::pair("mm", 1e-3), {"cm", 1e-2}, {"m", 1.0}})
    if (!length.in_metres && digits.ends_with(unit)) {
      digits.remove_suffix(std::string_view(unit).size());
      length.in_metres = true, metres = size;
    }
  const auto value = number_of(digits);
  if (!value || std::abs(*value) > kMostLength)
    return Error{ErrorCode::Invalid,
                 fmt::format("{} takes a length, such as 63mm or 0.02 (units of the scene), "
                             "not '{}'",
                             flag, text)};
  length.value = *value * metres;
  return length;
}

RigidTransform ViewOffset::T_recorded_view() const {
  const Eigen::Vector3d turn = turn_deg * (std::numbers::pi / 180);
  return {rotation(Eigen::Vector3d::UnitY() * turn[0]) * rotation(Eigen::Vector3d::UnitX() * turn[1]) *
              rotation(Eigen::Vector3d::UnitZ() * turn[2]),
          shift};
}

Result<ViewPath> ViewPath::parse_view(std::string_view text) {
  ViewPath view;
  const std::vector<std::string> parts = parts_of(text);
  if (parts.empty()) return view;
  if (parts.size() != 3 && parts.size() != 6)
    return Error{
        ErrorCode::Invalid,
        fmt::format("--view takes dx,dy,dz (right, down, forward) and perhaps yaw,pitch,roll in degrees, "
                    "such as 0.1,0,0 or 0.1,0,0,-5,0,0, not '{}'",
                    text)};
  Row row{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t column = kFirstLength + i;
    if (column < kFirstAngle) {
      const SceneLength length = TRY(parse_length("--view", parts[i]));
      row[column] = length.value, view.in_metres_ |= length.in_metres;
      continue;
    }
    const auto angle = number_of(parts[i]);
    if (!angle)
      return Error{ErrorCode::Invalid,
                   fmt::format("--view: '{}' is not an angle in degrees for {}", parts[i], kColumns[column])};
    row[column] = *angle;
  }
  TRY(check("--view", row));
  view.poses_.front().offset = offset_of(row);
  return view;
}

Result<ViewPath> ViewPath::read_path(Storage& storage, const std::string& path) {
  const std::string content = TRY(read_whole(storage, path));
  std::string_view text = content;
  if (std::ranges::find(content, '\0') != content.end()) return no_text(path);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // spreadsheets begin UTF-8 with it
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const bool json = trimmed(text.substr(0, 64), kAroundCells).starts_with('[') || path.ends_with(".json");
  const std::vector<Row> rows = TRY(json ? rows_of_json(path, text) : rows_of_csv(path, text));
  if (rows.size() > kMostPoses)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' has more than {} poses; leave some out", path, kMostPoses)};
  std::vector<Pose> poses;
  poses.reserve(rows.size());
  for (const Row& row : rows) poses.push_back({row[0], offset_of(row)});
  return of(std::move(poses), path);
}

Result<ViewPath> ViewPath::of(std::vector<Pose> poses, const std::string& path) {
  if (poses.empty())
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' has no poses; give each a line behind the names, or an object", path)};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double time_s = poses[i].time_s, before_s = poses[i - 1].time_s;
    if (time_s == before_s)
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}': two poses are of {:g} s; leave out one of them", path, time_s)};
    if (time_s < before_s)
      return Error{
          ErrorCode::Invalid,
          fmt::format("'{}': the poses are not in the order of their times: {:g} s follows {:g} s; sort them",
                      path, time_s, before_s)};
  }
  ViewPath view;
  view.poses_ = std::move(poses);
  return view;
}

ViewOffset ViewPath::at(double playback_s) const {
  if (playback_s <= poses_.front().time_s) return poses_.front().offset;
  if (playback_s >= poses_.back().time_s) return poses_.back().offset;
  const auto after = std::ranges::upper_bound(poses_, playback_s, {}, &Pose::time_s);
  const auto i = static_cast<std::size_t>(after - poses_.begin());
  const Pose &a = poses_[i - 1], &b = poses_[i];
  const Pose &before = poses_[i > 1 ? i - 2 : 0], &later = poses_[std::min(i + 1, poses_.size() - 1)];
  const double length_s = b.time_s - a.time_s, at = (playback_s - a.time_s) / length_s;
  const auto curve = [&](Eigen::Vector3d ViewOffset::*part) {
    Eigen::Vector3d value;
    for (int k = 0; k < 3; ++k) {
      const auto of = [&](const Pose& pose) { return (pose.offset.*part)[k]; };
      const auto slope = [&](const Pose& from, const Pose& to) {
        return (of(to) - of(from)) / (to.time_s - from.time_s);
      };
      value[k] = hermite({of(a), slope(before, b)}, {of(b), slope(a, later)}, length_s, at);
    }
    return value;
  };
  return {curve(&ViewOffset::shift), curve(&ViewOffset::turn_deg)};
}

bool ViewPath::in_place() const {
  return std::ranges::all_of(poses_, [](const Pose& pose) { return pose.offset.in_place(); });
}

}  // namespace hdrcam
