#include "firmware_host/sinks/scene_files/transforms_json.h"

#include <nlohmann/json.hpp>

#include "firmware_host/version.h"
#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

Json matrix_of(const RigidTransform& T_world_camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = T_world_camera.R * Eigen::Vector3d(1, -1, -1).asDiagonal();
  matrix.topRightCorner<3, 1>() = T_world_camera.t;
  matrix.array() += 0.0;  // no -0
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  return rows;
}

}  // namespace

std::string to_transforms_json(const PosedClip& clip, const std::string& folder) {
  Json json{{"camera_model", "OPENCV"},
            {"w", clip.width},
            {"h", clip.height},
            {"fl_x", clip.lens.fx_px},
            {"fl_y", clip.lens.fy_px},
            {"cx", clip.lens.cx_px},
            {"cy", clip.lens.cy_px},
            {"k1", 0},
            {"k2", 0},
            {"p1", 0},
            {"p2", 0}};
  json["hdrcam"] = {{"version", kVersion},
                    {"pose_source", name(clip.source)},
                    {"length_unit", name(clip.length_unit())},
                    {"lens", clip.lens_is_assumed ? "assumed" : "stated"},
                    {"frames_left_out", clip.left_out}};
  Json& frames = json["frames"] = Json::array();
  for (const PosedPicture& picture : clip.pictures) {
    Json frame{{"file_path", path_from(folder, picture.path)},
               {"transform_matrix", matrix_of(picture.T_world_camera)}};
    if (!picture.depth_path.empty()) frame["depth_file_path"] = path_from(folder, picture.depth_path);
    frame["time_s"] = picture.time_s;
    if (picture.exposure_s) frame["exposure_s"] = *picture.exposure_s;
    frames.push_back(std::move(frame));
  }
  return json_text(json, 1) + '\n';
}

}  // namespace hdrcam
