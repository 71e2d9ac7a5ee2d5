#include "firmware_host/settings/start_time.h"

#include <fmt/chrono.h>

#include "hal/clock.h"

namespace hdrcam {
namespace {

constexpr std::string_view kStart = "{start}";

std::string in_names(std::chrono::system_clock::time_point start) {
  return fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(start)));
}

void replace_in(std::string& name, const std::string& time) {
  for (std::size_t at = name.find(kStart); at != std::string::npos; at = name.find(kStart, at + time.size()))
    name.replace(at, kStart.size(), time);
}

}  // namespace

Settings with_start_time(Settings settings, std::chrono::system_clock::time_point start) {
  const std::string time = in_names(start);
  for (std::string* name : {&settings.record.file, &settings.output.http_takes, &settings.machine.trace})
    replace_in(*name, time);
  for (auto& [sink, path] : settings.output.paths) replace_in(path, time);
  return settings;
}

std::string named_at_start(const std::string& name) {
  std::string named = name;
  replace_in(named, in_names(posix_clock().wall_time()));
  return named;
}

}  // namespace hdrcam
