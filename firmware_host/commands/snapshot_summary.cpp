#include "firmware_host/commands/snapshot_summary.h"

#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

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
  std::string table = printable(path) + "\n";
  const auto row = [&](const char* what, const std::string& value) {
    table += fmt::format("  {:<12}{}\n", what, value);
  };
  const FilmedRecording times = filmed(scene);
  const Keyframe& last = newest(scene);
  row("content", "a snapshot of a scene");
  row("saved by", printable(scene.program));
  row("camera", scene.camera.name.empty() ? "(no name)" : printable(scene.camera.name));
  row("picture", fmt::format("{}x{}", scene.camera.width, scene.camera.height));
  row("frame rate", fmt::format("{:.6g} Hz", scene.camera.framerate_hz));
  row("frames", fmt::format("{}, number {} to {}", scene.frames.size(),
                            scene.frames.front().frame.facts.sequence, last.frame.facts.sequence));
  row("time", fmt::format("{:.6g} to {:.6g} s of the run", times.begin_s, times.duration_s));
  row("lens", fmt::format("f {:.6g} x {:.6g} px, centre {:.6g}, {:.6g}{}", last.lens.fx_px, last.lens.fy_px,
                          last.lens.cx_px, last.lens.cy_px, last.frame.lens_is_assumed ? ", assumed" : ""));
  row("poses", source_of_poses(scene));
  row("length unit", unit_of_lengths(scene));
  if (const int count = worlds(scene); count > 1)
    row("worlds", fmt::format("{}: tracking began anew in between", count));
  row("field", scene.has_field ? "yes" : "none: no depth, no other view");
  row("reference", fmt::format("{:.6g} s of exposure, white at radiance {:.4g}",
                               last.frame.reference_exposure, last.frame.white));
  row("size", fmt::format("{:.2f} MB", static_cast<double>(bytes) * 1e-6));
  row("complete", "yes");
  return table;
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
                     {"intrinsics",
                      {{"fx_px", last.lens.fx_px},
                       {"fy_px", last.lens.fy_px},
                       {"cx_px", last.lens.cx_px},
                       {"cy_px", last.lens.cy_px}}},
                     {"reference_exposure_s", last.frame.reference_exposure},
                     {"white", static_cast<double>(last.frame.white)},
                     {"bytes", bytes},
                     {"complete", true}};
  return json_text(json, 2) + "\n";
}

}  // namespace hdrcam
