#include "firmware_host/settings/start_time.h"

#include <fmt/chrono.h>

namespace hdrcam {
namespace {

constexpr std::string_view kStart = "{start}";

void replace_in(std::string& name, const std::string& time) {
  for (std::size_t at = name.find(kStart); at != std::string::npos; at = name.find(kStart, at + time.size()))
    name.replace(at, kStart.size(), time);
}

}  // namespace

Settings with_start_time(Settings settings, std::chrono::system_clock::time_point start) {
  const std::string time =
      fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(start)));
  for (std::string* name : {&settings.record.file, &settings.output.http_takes, &settings.machine.trace})
    replace_in(*name, time);
  for (auto& [sink, path] : settings.output.paths) replace_in(path, time);
  return settings;
}

}  // namespace hdrcam
