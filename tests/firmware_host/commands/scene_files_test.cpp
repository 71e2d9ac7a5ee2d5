// The files for other tools from outside: a simulated recording whose truth is known, the program, and
// readers that know the formats from their specifications alone.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "hal/recording/png_image.h"
#include "render/exr.h"
#include "render/scores/ground_truth.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/moving_scene.h"

#include "tests/firmware_host/commands/verb_runs.h"
#include "tests/support/ran.h"
#include "tests/support/scene_file_readers.h"

using namespace hdrcam;
using nlohmann::json;
using test::json_in;
using test::Pixel;
using test::ran_here;
using test::read_colmap;
using test::read_flow;
using test::read_transforms;
using test::ReadCamera;
using test::require_success;
using test::Vector3;
namespace fs = std::filesystem;

namespace {

constexpr int kFrames = 12, kRows = 96, kCols = 128;

// Copies the recording with the true pose of each frame, as a rig that knows its place would state it.
void state_poses(const std::string& place) {
  const json truth = json_in(place + "/clip/gt/gt.json");
  const auto reader = value_of(open_recording(posix_storage(), place + "/unposed.mkv"));
  const auto writer = value_of(create_recording(posix_storage(), place + "/lamps.mkv", reader->camera()));
  for (std::size_t i = 0; i < kFrames; ++i) {
    auto frame = value_of(reader->next());
    REQUIRE(frame);
    frame->facts.T_world_camera = truth["frames"][i]["c2w"].get<PoseMatrix>();
    require_done(writer->append(*frame));
  }
  require_done(writer->finish());
}

// An orbit around lamps, once for all tests: recording and truth. Poses, depth and motion are exact.
const std::string& filmed() {
  static const std::string folder = [] {
    const std::string place = sample::scratch_folder("scene_files");
    require_success(
        {"simulate", fmt::format("lamps?size={}x{}&without=rolling-shutter,distortion", kCols, kRows), "-o",
         place + "/unposed.mkv", "--truth", place + "/clip", "--frames", std::to_string(kFrames)});
    state_poses(place);
    return place;
  }();
  return folder;
}

// Truth of a frame.
struct Truth {
  Image<float> depth, flow;  // metres; [dx dy occluded] to the next frame
  Image<std::uint16_t> ids;
  std::vector<double> c2w;  // row-major 3x4; x right, y down, z forward
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::vector<int> moving;

  bool is_moving(int y, int x) const {
    return std::ranges::find(moving, static_cast<int>(ids.at(0, y, x))) != moving.end();
  }
  Vector3 world_point(int y, int x) const {
    const auto z = static_cast<double>(depth.at(0, y, x));
    const double p[3] = {(x + 0.5 - cx) / fx * z, (y + 0.5 - cy) / fy * z, z};
    double q[3];
    for (std::size_t r = 0; r < 3; ++r)
      q[r] = c2w[4 * r] * p[0] + c2w[4 * r + 1] * p[1] + c2w[4 * r + 2] * p[2] + c2w[4 * r + 3];
    return {q[0], q[1], q[2]};
  }
};

Truth truth_of(int frame) {
  const std::string gt = filmed() + "/clip/gt";
  const json facts = json_in(gt + "/gt.json");
  const std::string number = fmt::format("{:04}", frame);
  Truth truth;
  truth.depth = std::move(value_of(read_exr(posix_storage(), gt + "/depth/" + number + ".exr")).samples);
  const ExrImage flow = value_of(read_exr(posix_storage(), gt + "/flow/" + number + ".exr"));
  truth.flow = Image<float>(3, kRows, kCols);
  int plane = 0;
  for (const char* channel : {"R", "G", "B"})
    std::copy_n(flow.samples.plane(*flow.find(channel)), truth.flow.plane_size(), truth.flow.plane(plane++));
  truth.ids =
      std::move(value_of(read_png(posix_storage(), gt + "/id/" + number + ".png", kCols, kRows)).samples);
  truth.c2w = facts["frames"][static_cast<std::size_t>(frame)]["c2w"].get<std::vector<double>>();
  truth.fx = facts["fx"], truth.fy = facts["fy"], truth.cx = facts["cx"], truth.cy = facts["cy"];
  truth.moving = facts["moving_ids"].get<std::vector<int>>();
  return truth;
}

// How far from its true place in the next frame a camera sees what stands still, over one frame's pixels.
double worst_reprojection_px(int frame, const ReadCamera& next) {
  const Truth truth = truth_of(frame);
  double worst = 0;
  int compared = 0;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      if (truth.is_moving(y, x) || truth.flow.at(2, y, x) > 0) continue;
      const Pixel seen = next.project(truth.world_point(y, x));
      const double u = x + 0.5 + static_cast<double>(truth.flow.at(0, y, x)),
                   v = y + 0.5 + static_cast<double>(truth.flow.at(1, y, x));
      worst = std::max(worst, std::hypot(seen.u_px - u, seen.v_px - v));
      ++compared;
    }
  REQUIRE(compared > kRows * kCols / 2);
  return worst;
}

double median_of(std::vector<double> values) {
  REQUIRE_FALSE(values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A replay of the film with everything that other tools take, once for all tests.
const std::string& replayed() {
  static const std::string folder = [] {
    const std::string out = filmed() + "/given";
    require_success({"replay",
                     filmed() + "/lamps.mkv",
                     "--preset",
                     "fast",
                     "-o",
                     out + "/%06d.exr",
                     "--preview",
                     out + "/%06d.png",
                     "--layers",
                     "depth,flow,flow_forward,field_flow,field_flow_forward",
                     "--flow-forward",
                     out + "/f/%06d.flo",
                     "--flow-backward",
                     out + "/b/%06d.flo",
                     "--field-flow-forward",
                     out + "/ff/%06d.flo",
                     "--field-flow-backward",
                     out + "/fb/%06d.flo",
                     "--depth",
                     out + "/depth/%06d.png",
                     "--transforms",
                     out + "/transforms.json",
                     "--colmap",
                     out + "/colmap",
                     "--stats",
                     out + "/stats.json"});
    return out;
  }();
  return folder;
}

ExrImage exr_of(const std::string& folder, int frame) {
  return value_of(read_exr(posix_storage(), fmt::format("{}/{:06}.exr", folder, frame)));
}

// Of the pixels that are seen in the next frame, against the truth: px.
double median_error_of_forward_motion(const std::string& flow_folder) {
  std::vector<double> errors;
  for (int frame = 2; frame + 1 < kFrames; ++frame) {
    const auto flow = read_flow(fmt::format("{}/{:06}.flo", flow_folder, frame));
    const Truth truth = truth_of(frame);
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        if (!(truth.flow.at(2, y, x) > 0))
          errors.push_back(std::hypot(static_cast<double>(flow.u(y, x) - truth.flow.at(0, y, x)),
                                      static_cast<double>(flow.v(y, x) - truth.flow.at(1, y, x))));
  }
  return median_of(errors);
}

}  // namespace

TEST_CASE("exported poses project the scene's points to the pixels where the truth sees them") {
  const std::string out = filmed() + "/export";
  require_success({"export", filmed() + "/lamps.mkv", "-o", out, "--transforms", "--colmap"});
  const auto transforms = read_transforms(out + "/transforms.json");
  const auto model = read_colmap(out + "/colmap");
  CHECK(transforms.json["w"] == kCols);
  CHECK(transforms.json["h"] == kRows);
  CHECK(transforms.json["camera_model"] == "OPENCV");
  CHECK(transforms.json["hdrcam"]["pose_source"] == "given");
  CHECK(transforms.json["hdrcam"]["length_unit"] == "metre");
  CHECK((model.width == kCols && model.height == kRows));
  CHECK(transforms.cameras.size() == kFrames);
  CHECK(model.images.size() == kFrames);
  CHECK(model.points.empty());  // an export measures no depth
  for (int frame = 0; frame + 1 < kFrames; ++frame) {
    const std::string next = fmt::format("ldr/{:04}.png", frame + 1);
    CHECK(fs::exists(out + "/" + next));
    CHECK(worst_reprojection_px(frame, transforms.cameras.at(next)) < 0.02);
    CHECK(worst_reprojection_px(frame, model.named(next).camera) < 0.02);
  }
}

TEST_CASE("a replay's poses are those given, and its files name the pictures that it wrote") {
  const auto transforms = read_transforms(replayed() + "/transforms.json");
  const auto model = read_colmap(replayed() + "/colmap");
  REQUIRE(transforms.cameras.size() == kFrames);
  REQUIRE(model.images.size() == kFrames);
  for (const auto& frame : transforms.json["frames"])
    for (const char* path : {"file_path", "depth_file_path"})
      CHECK(fs::exists(replayed() + "/" + frame[path].get<std::string>()));
  for (int frame = 0; frame + 1 < kFrames; ++frame) {
    const std::string next = fmt::format("{:06}.exr", frame + 1);
    CHECK(worst_reprojection_px(frame, transforms.cameras.at(next)) < 0.02);
    CHECK(worst_reprojection_px(frame, model.named(next).camera) < 0.02);
  }
}

TEST_CASE(
    "COLMAP's points are where the depth was measured, of what stands still, in the recording's metres") {
  const auto model = read_colmap(replayed() + "/colmap");
  REQUIRE(model.points.size() > 100);
  std::vector<double> errors;
  int on_moving = 0;
  for (const auto& [id, point] : model.points) {
    REQUIRE(point.track.size() == 1);
    const auto& image = model.images.at(point.track[0].first);
    const auto& sighting = image.sightings.at(static_cast<std::size_t>(point.track[0].second));
    REQUIRE(sighting.point == id);
    const Pixel seen = image.camera.project(point.p_world);
    REQUIRE(std::hypot(seen.u_px - sighting.at.u_px, seen.v_px - sighting.at.v_px) < 0.01);
    static std::map<std::string, Truth> truths;
    if (!truths.contains(image.name)) truths.emplace(image.name, truth_of(std::stoi(image.name)));
    const Truth& truth = truths.at(image.name);
    const int y = static_cast<int>(sighting.at.v_px), x = static_cast<int>(sighting.at.u_px);
    on_moving += truth.is_moving(y, x);
    errors.push_back(
        std::abs(image.camera.in_camera(point.p_world).z / static_cast<double>(truth.depth.at(0, y, x)) - 1));
    for (const int code : point.rgb) REQUIRE((code >= 0 && code <= 255));
  }
  CHECK(median_of(errors) < 0.1);
  CHECK(on_moving < static_cast<int>(model.points.size()) / 10);
}

TEST_CASE("a .flo file holds what the EXR layer of its frame holds, to the float") {
  const std::pair<const char*, const std::string_view(*)[2]> kinds[] = {
      {"f", &exr_channel::kFlowForward},
      {"b", &exr_channel::kFlowBackward},
      {"ff", &exr_channel::kFieldFlowForward},
      {"fb", &exr_channel::kFieldFlow}};
  for (const auto& [folder, channels] : kinds)
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto flow = read_flow(fmt::format("{}/{}/{:06}.flo", replayed(), folder, frame));
      REQUIRE((flow.width == kCols && flow.height == kRows));
      const bool forward = std::string_view(folder).starts_with('f') && std::string_view(folder) != "fb";
      const bool unknown = std::string_view(folder) == "f"   ? frame == kFrames - 1
                           : std::string_view(folder) == "b" ? frame == 0
                                                             : false;
      INFO(folder << ", frame " << frame << (forward ? " forward" : " backward"));
      REQUIRE(flow.known(0, 0) != unknown);
      const ExrImage exr = exr_of(replayed(), frame);
      const int u = *exr.find((*channels)[0]), v = *exr.find((*channels)[1]);
      bool same = true;
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x)
          same &= unknown
                      ? exr.samples.at(u, y, x) == 0 && !flow.known(y, x)
                      : exr.samples.at(u, y, x) == flow.u(y, x) && exr.samples.at(v, y, x) == flow.v(y, x);
      CHECK(same);
    }
}

TEST_CASE("forward motion leads to where the truth has the pixel in the next frame") {
  CHECK(median_error_of_forward_motion(replayed() + "/f") < 0.25);
  CHECK(median_error_of_forward_motion(replayed() + "/ff") < 1.0);
}

TEST_CASE("the field's forward motion is that of the truth once the field was fitted to the next frame") {
  const std::string out = filmed() + "/fitted";
  require_success({"replay", filmed() + "/lamps.mkv", "--preset", "fast", "--lookahead", "2",
                   "--field-flow-forward", out + "/%06d.flo"});
  CHECK(median_error_of_forward_motion(out) < 0.2);  // no motion at all: .34
}

TEST_CASE("depth is in metres where poses are given, as layer and as picture") {
  std::vector<double> errors;
  for (const int frame : {4, 8}) {
    const ExrImage exr = exr_of(replayed(), frame);
    CHECK(exr.attributes.texts.at("hdrcam.unit.Z").find("metre") != std::string::npos);
    const auto picture = value_of(
        read_png(posix_storage(), fmt::format("{}/depth/{:06}.png", replayed(), frame), kCols, kRows));
    const Truth truth = truth_of(frame);
    const int z = *exr.find("Z");
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const auto depth = static_cast<double>(exr.samples.at(z, y, x));
        REQUIRE(std::abs(picture.samples.at(0, y, x) - (depth < 65.535 ? 1000 * depth : 0)) <= 1);
        if (!truth.is_moving(y, x))
          errors.push_back(std::abs(depth / static_cast<double>(truth.depth.at(0, y, x)) - 1));
      }
  }
  CHECK(median_of(errors) < 0.35);  // in another unit it is off by factors
}

TEST_CASE("stats.json and the EXR files state each frame's pose and that it was given") {
  const json stats = json_in(replayed() + "/stats.json");
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto& pose = stats["per_frame"][static_cast<std::size_t>(frame)]["pose"];
    CHECK(pose["source"] == "given");
    CHECK(pose["length_unit"] == "metre");
    CHECK_FALSE(pose.contains("lost"));
    const std::vector<double> truth = truth_of(frame).c2w;
    const ExrAttributes attributes = exr_of(replayed(), frame).attributes;
    CHECK(attributes.texts.at("hdrcam.poseSource") == "given");
    CHECK(attributes.texts.at("hdrcam.lengthUnit") == "metre");
    REQUIRE(attributes.T_world_camera);
    for (std::size_t i = 0; i < 12; ++i) {
      CHECK(pose["T_world_camera"][i].get<double>() == Approx(truth[i]).margin(1e-9));
      CHECK((*attributes.T_world_camera)[i] == Approx(truth[i]).margin(1e-5));
    }
  }
}

TEST_CASE("tracked poses leave in the same files and say that they were tracked") {
  const std::string out = filmed() + "/tracked";
  require_success({"replay", filmed() + "/lamps.mkv", "--preset", "fast", "--set", "pose=tracked", "-o",
                   out + "/%06d.exr", "--transforms", out + "/transforms.json", "--colmap", out + "/colmap",
                   "--stats", out + "/stats.json"});
  const json stats = json_in(out + "/stats.json");
  const auto transforms = read_transforms(out + "/transforms.json");
  CHECK(transforms.json["hdrcam"]["pose_source"] == "tracked");
  CHECK(transforms.json["hdrcam"]["length_unit"] == "median depth of the first view");
  const std::vector<double> first = truth_of(0).c2w;
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto& pose = stats["per_frame"][static_cast<std::size_t>(frame)]["pose"];
    CHECK(pose["source"] == "tracked");
    const ExrAttributes attributes = exr_of(out, frame).attributes;
    CHECK(attributes.texts.at("hdrcam.poseSource") == "tracked");
    const bool lost = pose.contains("lost");
    CHECK(attributes.texts.contains("hdrcam.poseLost") == lost);
    CHECK(transforms.cameras.contains(fmt::format("{:06}.exr", frame)) == !lost);
    // the world is the first camera: the angle to it is that of the truth
    const std::vector<double> now = truth_of(frame).c2w;
    double true_trace = 0, trace = 0;
    for (std::size_t r = 0; r < 3; ++r) {
      trace += pose["T_world_camera"][5 * r].get<double>();
      for (std::size_t k = 0; k < 3; ++k) true_trace += first[4 * k + r] * now[4 * k + r];
    }
    const auto angle_deg = [](double sum) {
      return std::acos(std::clamp((sum - 1) / 2, -1.0, 1.0)) * 180 / std::numbers::pi;
    };
    CHECK(angle_deg(trace) == Approx(angle_deg(true_trace)).margin(1.2));
  }
  CHECK(stats["per_frame"][0]["pose"]["T_world_camera"] ==
        json({1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0}));
}

TEST_CASE("a film's poses are in the recording's world: from its own place they are the recorded ones") {
  const std::string out = filmed() + "/film";
  require_success({"render", filmed() + "/lamps.mkv", "--preset", "fast", "--ldr", "-o", out + "/%06d.png",
                   "--size", "64x48", "--transforms", out + "/transforms.json"});
  const auto transforms = read_transforms(out + "/transforms.json");
  CHECK(transforms.json["w"] == 64);
  REQUIRE(transforms.cameras.size() == kFrames);
  const Truth truth = truth_of(3);
  const Pixel seen = transforms.cameras.at("000003.png").project(truth.world_point(10, 20));
  CHECK(seen.u_px == Approx(20.5 / 2).margin(0.01));
  CHECK(seen.v_px == Approx(10.5 / 2).margin(0.01));
}

TEST_CASE("without a field a model has the frames that state a pose, also where the first states none") {
  const std::string folder = sample::scratch_folder("scene_files_some"), clip = folder + "/some.mkv";
  const test::MovingScene scene;
  auto writer = create_recording(posix_storage(), clip, scene.camera()).value();
  for (int i = 0; i < 7; ++i) {
    RawFrame frame = scene.frame(i);
    if (i >= 2 && i != 4) frame.facts.T_world_camera = PoseMatrix{1, 0, 0, 0.01 * i, 0, 1, 0, 0, 0, 0, 1, 0};
    REQUIRE(writer->append(frame).ok());
  }
  REQUIRE(writer->finish().ok());
  require_success({"replay", clip, "--preset", "fast", "--emit", "state", "--preview", folder + "/%06d.png",
                   "--transforms", folder + "/transforms.json"});
  const auto read = read_transforms(folder + "/transforms.json");
  CHECK(read.cameras.size() == 4);
  for (const char* stated : {"000002.png", "000003.png", "000005.png", "000006.png"})
    CHECK(read.cameras.contains(stated));
  CHECK(read.json["hdrcam"]["frames_left_out"] == 3);

  const auto exported = test::ran({"export", clip, "-o", folder + "/clip", "--transforms"});
  CHECK(exported.exit_code == 0);
  CHECK(exported.output.find("note: 3 frames without a pose are in the clip.json only\n") !=
        std::string::npos);
  CHECK(read_transforms(folder + "/clip/transforms.json").cameras.size() == 4);
}

TEST_CASE("given poses leave without a field too, and an earlier flow is kept unless --force is given") {
  const std::string folder = sample::scratch_folder("scene_files_state");
  const std::vector<std::string> words{"replay",         filmed() + "/lamps.mkv",
                                       "--preset",       "fast",
                                       "--emit",         "state",
                                       "--preview",      folder + "/%06d.png",
                                       "--transforms",   folder + "/transforms.json",
                                       "--flow-forward", folder + "/%06d.flo"};
  require_success(words);
  CHECK(read_transforms(folder + "/transforms.json").cameras.contains("000002.png"));
  CHECK(ran_here(words).exit_code == exit_code_of(ErrorCode::Exists));
}
