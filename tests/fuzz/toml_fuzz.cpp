// A file of settings: what is accepted is printed, and is accepted again as the same.
#include <string_view>

#include "firmware_host/settings/settings_toml.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Settings settings;
  if (!read_toml({reinterpret_cast<const char*>(data), size}, "x.toml", settings)) return 0;
  const std::vector<SettingGroup> all{SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,
                                      SettingGroup::Fit,    SettingGroup::Knobs,    SettingGroup::Output,
                                      SettingGroup::Record, SettingGroup::Machine};
  const std::string printed = to_toml(settings, all);
  Settings again;
  HDRCAM_CHECK(read_toml(printed, "x.toml", again).ok());
  HDRCAM_CHECK(to_toml(again, all) == printed);
  return 0;
}
