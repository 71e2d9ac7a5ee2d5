#include "firmware_host/commands/snapshot_summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "firmware_host/commands/summary_table.h"
#include "firmware_host/printable.h"
#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

const Keyframe& newest(const SceneHead& scene) { return scene.frames.back(); }

const char* unit_of_lengths(const SceneHead& scene) {
  const Keyframe* posed = newest_posed(scene);
  return posed != nullptr ? name(posed->frame.length_unit) : name(LengthUnit::Unknown);
}

const char* source_of_poses(const SceneHead& scene) {
  const Keyframe* posed = newest_posed(scene);
  return posed != nullptr ? name(posed->frame.pose->source) : "none";
}

int worlds(const SceneHead& scene) {
  int count = 1;
  for (std::size_t i = 1; i < scene.frames.size(); ++i)
    count += scene.frames[i].world != scene.frames[i - 1].world;
  return count;
}

}  // namespace

std::string as_table(const SceneHead& scene, const std::string& path, std::uint64_t bytes) {
  SummaryTable table(path);
  const FilmedRecording times = filmed(scene);
  const Keyframe& last = newest(scene);
  table.row("content", "a snapshot of a scene");
  table.row("saved by", printable(scene.program));
  table.row("camera", shown_name(scene.camera.name));
  table.row("picture", fmt::format("{}x{}", scene.camera.width, scene.camera.height));
  table.row("frame rate", fmt::format("{:.6g} Hz", scene.camera.framerate_hz));
  table.row("frames", fmt::format("{}, number {} to {}", scene.frames.size(),
                                  scene.frames.front().frame.facts.sequence, last.frame.facts.sequence));
  table.row("time", fmt::format("{:.6g} to {:.6g} s of the run", times.begin_s, times.duration_s));
  table.row("lens", describe(last.lens) + (last.frame.lens_is_assumed ? ", assumed" : ""));
  table.row("poses", source_of_poses(scene));
  table.row("length unit", unit_of_lengths(scene));
  if (const int count = worlds(scene); count > 1)
    table.row("worlds", fmt::format("{}: tracking began anew in between", count));
  table.row("field", scene.has_field ? "yes" : "none: no depth, no other view");
  table.row("reference", fmt::format("{:.6g} s of exposure, white at radiance {:.4g}",
                                     last.frame.reference_exposure, last.frame.white));
  table.row("size", describe_size(bytes));
  table.row("complete", "yes");
  return table.text();
}

std::string as_json(const SceneHead& scene, const std::string& path, std::uint64_t bytes) {
  const FilmedRecording times = filmed(scene);
  const Keyframe& last = newest(scene);
  Json frames = Json::array();
  for (const Keyframe& key : scene.frames)
    frames.push_back({{"sequence", key.frame.facts.sequence},
                      {"time_s", to_seconds(key.frame.facts.timestamp - scene.first)},
                      {"exposure", static_cast<double>(key.frame.exposure)},
                      {"world", key.world}});
  const Json json = {{"snapshot", path},
                     {"program", scene.program},
                     {"name", scene.camera.name},
                     {"width", scene.camera.width},
                     {"height", scene.camera.height},
                     {"framerate_hz", scene.camera.framerate_hz},
                     {"begin_s", times.begin_s},
                     {"end_s", times.duration_s},
                     {"frames", frames},
                     {"field", scene.has_field},
                     {"poses", source_of_poses(scene)},
                     {"length_unit", unit_of_lengths(scene)},
                     {"intrinsics", json_of(last.lens)},
                     {"reference_exposure_s", last.frame.reference_exposure},
                     {"white", static_cast<double>(last.frame.white)},
                     {"bytes", bytes},
                     {"complete", true}};
  return json_text(json, 2) + "\n";
}

}  // namespace hdrcam
