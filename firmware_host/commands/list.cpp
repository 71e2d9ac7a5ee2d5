// hdrcam list: shows the devices, their capabilities and what is missing for each.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware_host/commands/command.h"
#include "firmware_host/terminal.h"
#include "hal/core/json_text.h"
#include "hal/real/camera_libcamera.h"
#include "hal/real/enumerate.h"

namespace hdrcam {
namespace {

struct ListFlags {
  bool json = false, verbose = false;
};

struct Section {
  DeviceKind kind;
  const char* word;  // in --json
  const char* heading;
  const char* none;
};
constexpr Section kSections[] = {
    {DeviceKind::Camera, "camera", "Cameras", "none; connect one, or use a simulated one: --camera sim:walk"},
    {DeviceKind::GpioChip, "gpio", "GPIO chips", "none; a sync line needs one"},
    {DeviceKind::Graphics, "graphics", "Graphics devices",
     "none found by Vulkan; hdrcam computes on the processor"},
};

void print_text(const std::vector<FoundDevice>& devices) {
  for (const Section& section : kSections) {
    say("{}:\n", section.heading);
    bool any = false;
    for (const FoundDevice& device : devices) {
      if (device.kind != section.kind) continue;
      any = true;
      say("  {}\n", device.id.empty() ? device.title : fmt::format("{}  {}", device.id, device.title));
      for (const std::string& fact : device.facts) say("      {}\n", fact);
      for (const std::string& missing : device.missing) say("    ! {}\n", missing);
    }
    if (!any) say("  {}\n", section.none);
  }
}

void print_json(const std::vector<FoundDevice>& devices) {
  nlohmann::json list = nlohmann::json::array();
  for (const FoundDevice& device : devices) {
    const auto* section = std::find_if(std::begin(kSections), std::end(kSections),
                                       [&](const Section& s) { return s.kind == device.kind; });
    list.push_back({{"kind", section->word},
                    {"id", device.id},
                    {"title", device.title},
                    {"facts", device.facts},
                    {"missing", device.missing}});
  }
  say("{}\n", json_text(list, 2));
}

}  // namespace

void add_list(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<ListFlags>();
  CommandLine verb =
      program.add_verb("list", "show cameras, GPIO lines and graphics devices, and what is missing for each");
  verb.add_switch("--json", flags->json, "as JSON, for programs");
  verb.add_switch("--verbose", flags->verbose, "show libcamera's log");
  verb.on_chosen([flags, &chosen] {
    chosen = [flags](Surroundings&) -> Result<void> {
      if (flags->verbose) show_libcamera_log();
      const auto devices = list_devices();
      flags->json ? print_json(devices) : print_text(devices);
      return {};
    };
  });
}

}  // namespace hdrcam
