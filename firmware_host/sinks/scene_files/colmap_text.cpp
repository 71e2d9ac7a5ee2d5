#include "firmware_host/sinks/scene_files/colmap_text.h"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <iterator>
#include <span>
#include <vector>

namespace hdrcam {
namespace {

// Identifiers begin at 1.
std::size_t id_of(std::size_t index) { return index + 1; }

std::string cameras_of(const PosedClip& clip) {
  return fmt::format(
      "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[] (fx, fy, cx, cy)\n"
      "# lens: {}\n"
      "1 PINHOLE {} {} {:.17g} {:.17g} {:.17g} {:.17g}\n",
      clip.lens_is_assumed ? "assumed, the camera reports none" : "as the recording states it", clip.width,
      clip.height, clip.lens.fx_px, clip.lens.fy_px, clip.lens.cx_px, clip.lens.cy_px);
}

// The points that a picture saw, as indices, in the order of its POINTS2D.
using Sightings = std::vector<std::vector<std::size_t>>;

Sightings sightings_of(const PosedClip& clip) {
  Sightings seen(clip.pictures.size());
  for (std::size_t i = 0; i < clip.points.size(); ++i) seen[clip.points[i].picture].push_back(i);
  return seen;
}

std::string images_of(const PosedClip& clip, const std::string& folder, const Sightings& seen) {
  std::string text = fmt::format(
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n"
      "# poses: {}; unit of length: {}\n",
      name(clip.source), name(clip.length_unit()));
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < clip.pictures.size(); ++i) {
    const RigidTransform T_camera_world = clip.pictures[i].T_world_camera.inverse();
    Eigen::Quaterniond q = Eigen::Quaterniond(T_camera_world.R).normalized();
    if (q.w() < 0) q.coeffs() *= -1;
    const Eigen::Vector3d t = T_camera_world.t.array() + 0.0;  // no -0
    fmt::format_to(out, "{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} 1 {}\n", id_of(i), q.w(),
                   q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), path_from(folder, clip.pictures[i].path));
    const char* separator = "";
    for (const std::size_t point : seen[i]) {
      fmt::format_to(out, "{}{:g} {:g} {}", separator, clip.points[point].u_px, clip.points[point].v_px,
                     id_of(point));
      separator = " ";
    }
    text += '\n';
  }
  return text;
}

std::string points_of(const PosedClip& clip, const Sightings& seen) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  const auto out = std::back_inserter(text);
  for (std::size_t picture = 0; picture < seen.size(); ++picture)
    for (std::size_t k = 0; k < seen[picture].size(); ++k) {
      const std::size_t i = seen[picture][k];
      const ColouredPoint& point = clip.points[i];
      // twelve digits: to a hundredth of a millimetre anywhere on Earth
      fmt::format_to(out, "{} {:.12g} {:.12g} {:.12g} {} {} {} -1 {} {}\n", id_of(i), point.p_world.x(),
                     point.p_world.y(), point.p_world.z(), point.rgb[0], point.rgb[1], point.rgb[2],
                     id_of(picture), k);
    }
  return text;
}

}  // namespace

Result<void> write_colmap(Storage& storage, const std::string& model, const PosedClip& clip,
                          const std::string& folder) {
  TRY(storage.make_directories(model));
  const Sightings seen = sightings_of(clip);
  const std::string texts[] = {cameras_of(clip), images_of(clip, folder, seen), points_of(clip, seen)};
  for (std::size_t i = 0; i < kColmapFiles.size(); ++i)
    TRY(write_whole(storage, fmt::format("{}/{}", model, kColmapFiles[i]),
                    std::as_bytes(std::span(texts[i]))));
  return {};
}

}  // namespace hdrcam
