#include "firmware_host/simulation/truth_folder.h"

#include <algorithm>

#include "firmware_host/sinks/output_folder.h"
#include "hal/core/json_text.h"
#include "render/exr.h"
#include "render/png.h"

namespace hdrcam {
namespace {

constexpr int kCurveSamples = 1024;  // of a response in crf.csv

// What changes the light of a picture and not the true radiance (hal/sim/scene_truth.h).
constexpr Effect kNotInTruth[] = {Effect::MotionBlur,   Effect::RollingShutter, Effect::Flare,
                                  Effect::MainsFlicker, Effect::HotPixels,      Effect::Noise};

std::array<double, 12> matrix(const Pose& pose) {
  const Mat3& R = pose.rotation;
  const Vec3 t = pose.position;
  std::array<double, 12> m{};
  const Vec3 columns[] = {R.c0, R.c1, R.c2, t};
  for (std::size_t c = 0; c < 4; ++c) m[c] = columns[c].x, m[4 + c] = columns[c].y, m[8 + c] = columns[c].z;
  return m;
}

// Writes the planes of one image as the named channels.
Result<void> write_exr(Storage& storage, const std::string& path, const Image<float>& image,
                       std::initializer_list<const char*> names, ExrSample stored) {
  ExrPicture picture;
  picture.rows = image.rows(), picture.cols = image.cols();
  picture.compression = ExrCompression::Zip;
  int channel = 0;
  for (const char* name_text : names)
    picture.channels.push_back({name_text, {image.plane(channel++), image.plane_size()}, stored});
  return write_whole(storage, path, TRY(encode_exr(picture)), Durability::WrittenBack);
}

// Relative code at kCurveSamples even steps of relative exposure, one line a channel.
std::string curve_table(const Simulation& simulation) {
  std::string text;
  for (int channel = 0; channel < 3; ++channel)
    for (int i = 0; i < kCurveSamples; ++i) {
      const double x = i / (kCurveSamples - 1.0);
      const bool curved = simulation.plan.on(Effect::Response);
      text += fmt::format("{:.6g}{}", curved ? ResponseCurve::exact(simulation.response, channel, x) : x,
                          i + 1 < kCurveSamples ? ',' : '\n');
    }
  return text;
}

}  // namespace

void TruthFolder::describe_sensor(const SimulatedSensor& sensor) {
  const Simulation& s = simulation_;
  json_["axes"] = "x right, y down, z forward; c2w row-major 3x4";
  json_["sensor_gain_per_s"] = s.sensitivity_per_s;
  json_["radiance_to_sensor"] = fmt::format("x = R*exposure_s*gain*{}, clip at 1", s.sensitivity_per_s);
  json_["radiance_leaves_out"] = nlohmann::ordered_json::array();
  for (const Effect effect : kNotInTruth)
    if (s.plan.on(effect)) json_["radiance_leaves_out"].push_back(name(effect));
  json_["sensor_to_code"] = fmt::format(
      "code = (b + (1-b)*crf(x)) * (2^bits-1), b = black_level; crf.csv: {} values, x = 0..1", kCurveSamples);
  json_["black_level"] = s.black_level;
  json_["full_well_e"] = s.full_well_e;
  json_["read_noise_e"] = s.plan.on(Effect::Noise) ? s.noise.read_noise_e : 0;
  const Intrinsics& lens = sensor.lens().intrinsics;
  json_["fx"] = lens.fx_px, json_["fy"] = lens.fy_px, json_["cx"] = lens.cx_px, json_["cy"] = lens.cy_px;
  if (!s.plan.on(Effect::Distortion)) return;
  json_["distortion"] = {{"k1", s.distortion.k1}, {"k2", s.distortion.k2}};
  json_["distortion_of"] = "the ray r is seen at r*(1 + k1*|r|^2 + k2*|r|^4)";
}

Result<TruthFolder> TruthFolder::create(Storage& storage, const std::string& folder,
                                        const SimulatedSensor& sensor, const std::string& spec) {
  TruthFolder truth(storage, folder + "/" + kFolder);
  for (const char* frames : kFrames) TRY(make_folder_of(storage, truth.folder_ + "/" + frames));
  truth.simulation_ = sensor.simulation();
  auto& json = truth.json_;
  json["options"]["simulation"] = spec;
  for (std::size_t i = 0; i < kEffects; ++i)
    if (truth.simulation_.plan.on(static_cast<Effect>(i)))
      json["options"]["effects"].push_back(name(static_cast<Effect>(i)));
  truth.describe_sensor(sensor);
  json["frames"] = nlohmann::ordered_json::array();
  json["moving_ids"] = nlohmann::ordered_json::array();
  const auto& objects = sensor.scene()->objects;
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (objects[i].moves()) json["moving_ids"].push_back(i);
  return truth;
}

Result<void> TruthFolder::write_pictures(const SceneTruth& truth) {
  const auto path = [&](const char* kind, const char* extension) {
    return fmt::format("{}/{}/{:04d}.{}", folder_, kind, json_["frames"].size(), extension);
  };
  TRY(write_exr(*storage_, path("hdr", "exr"), truth.radiance, {"R", "G", "B"}, ExrSample::Half));
  TRY(write_exr(*storage_, path("depth", "exr"), truth.depth, {"Z"}, ExrSample::Float));
  TRY(write_exr(*storage_, path("flow", "exr"), truth.flow, {"R", "G", "B"}, ExrSample::Float));
  return write_whole(*storage_, path("id", "png"), TRY(encode_png(truth.ids)), Durability::WrittenBack);
}

Result<void> TruthFolder::append(const SceneTruth& truth, const FrameFacts& facts) {
  TRY(write_pictures(truth));
  const double saturation = 1 / (simulation_.sensitivity_per_s * facts.exposure());
  json_["frames"].push_back({{"time_s", truth.time_s},
                             {"sequence", facts.sequence},
                             {"exposure_s", facts.exposure_s},
                             {"gain", facts.analogue_gain},
                             {"r_sat", saturation},
                             {"c2w", matrix(truth.T_world_camera)}});
  shortest_exposure_ =
      shortest_exposure_ == 0 ? facts.exposure() : std::min(shortest_exposure_, facts.exposure());
  const auto radiance = truth.radiance.samples();
  brightest_ = std::max(brightest_, *std::max_element(radiance.begin(), radiance.end()));
  return {};
}

Result<void> TruthFolder::finish() {
  json_["r_sat_shortest"] = 1 / (simulation_.sensitivity_per_s * shortest_exposure_);
  json_["r_max"] = brightest_;
  const std::string text = json_text(json_, 1) + "\n", curves = curve_table(simulation_);
  TRY(write_whole(*storage_, folder_ + "/crf.csv", std::as_bytes(std::span(curves))));
  return write_whole(*storage_, folder_ + "/gt.json", std::as_bytes(std::span(text)));
}

}  // namespace hdrcam
