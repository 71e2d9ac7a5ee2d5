#include "firmware_host/log_format.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

std::atomic<LogFormat> format_in_use{LogFormat::Text};

const char* name(LogLevel level) {
  switch (level) {
    case LogLevel::Status:
      return "status";
    case LogLevel::Note:
      return "note";
    case LogLevel::Warning:
      return "warning";
    case LogLevel::Error:
      return "error";
  }
  return "";
}

std::string now_in_utc() {
  using std::chrono::milliseconds;
  const auto now = std::chrono::time_point_cast<milliseconds>(std::chrono::system_clock::now());
  const auto ms = now.time_since_epoch().count() % 1000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(now)),
                     ms);
}

}  // namespace

void set_log_format(LogFormat format) { format_in_use = format; }
LogFormat log_format() { return format_in_use; }

std::string json_log_line(LogLevel level, std::string_view message) {
  const nlohmann::ordered_json line{
      {"time", now_in_utc()}, {"level", name(level)}, {"message", std::string(message)}};
  return json_text(line) + '\n';
}

std::string json_log_lines(std::string_view remarks) {
  constexpr std::pair<std::string_view, LogLevel> kPrefixes[] = {{"note: ", LogLevel::Note},
                                                                 {"warning: ", LogLevel::Warning}};
  std::string lines;
  while (!remarks.empty()) {
    const std::size_t end = std::min(remarks.find('\n'), remarks.size());
    std::string_view line = remarks.substr(0, end);
    remarks.remove_prefix(std::min(end + 1, remarks.size()));
    LogLevel level = LogLevel::Note;
    for (const auto& [prefix, its_level] : kPrefixes)
      if (line.starts_with(prefix)) level = its_level, line.remove_prefix(prefix.size());
    if (!line.empty()) lines += json_log_line(level, line);
  }
  return lines;
}

}  // namespace hdrcam
