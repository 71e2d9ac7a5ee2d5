// Readers of the files for reconstruction and flow tools, written from their specifications and from nothing
// of the product: transforms.json and COLMAP's text as cameras that project points, .flo as vectors. Include
// last: it brings Catch2.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "hal/storage.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

struct Pixel {
  double u_px = 0, v_px = 0;
};

// A camera as a file states it: world to camera, rows of [R t], with z along the direction of view.
struct ReadCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  double R[3][3] = {}, t[3] = {};

  Vector3 in_camera(const Vector3& p) const {
    double q[3];
    for (int r = 0; r < 3; ++r) q[r] = R[r][0] * p.x + R[r][1] * p.y + R[r][2] * p.z + t[r];
    return {q[0], q[1], q[2]};
  }
  Pixel project(const Vector3& p) const {
    const Vector3 q = in_camera(p);
    return {fx * q.x / q.z + cx, fy * q.y / q.z + cy};
  }
};

// docs.nerf.studio/quickstart/data_conventions.html: camera to world; x right, y up, the view along -z.
struct ReadTransforms {
  nlohmann::json json;
  std::map<std::string, ReadCamera> cameras;  // by file_path
};
inline ReadTransforms read_transforms(const std::string& path) {
  ReadTransforms read;
  read.json = nlohmann::json::parse(read_whole(posix_storage(), path).value());
  for (const auto& frame : read.json["frames"]) {
    const auto& M = frame["transform_matrix"];
    REQUIRE(M.size() == 4);
    REQUIRE(M[3] == nlohmann::json({0.0, 0.0, 0.0, 1.0}));
    ReadCamera camera{read.json["fl_x"], read.json["fl_y"], read.json["cx"], read.json["cy"]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double sign = axis == 0 ? 1 : -1;  // of the camera's axis, from OpenGL's to the image's
      for (std::size_t k = 0; k < 3; ++k) {
        camera.R[axis][k] = sign * M[k][axis].get<double>();
        camera.t[axis] -= camera.R[axis][k] * M[k][3].get<double>();
      }
    }
    read.cameras[frame["file_path"]] = camera;
  }
  return read;
}

// colmap.github.io/format.html: world to camera as a quaternion w x y z and a translation; x right, y down.
struct ReadColmap {
  struct Sighting {
    Pixel at;
    int point = -1;
  };
  struct Image {
    std::string name;
    ReadCamera camera;
    std::vector<Sighting> sightings;
  };
  struct Point {
    Vector3 p_world;
    int rgb[3] = {};
    std::vector<std::pair<int, int>> track;  // image, index of its sighting
  };
  int width = 0, height = 0;
  std::map<int, Image> images;
  std::map<int, Point> points;

  const Image& named(const std::string& name) const {
    for (const auto& [id, image] : images)
      if (image.name == name) return image;
    FAIL("no image " << name);
    return images.begin()->second;
  }
};

inline std::vector<std::string> data_lines(const std::string& path) {
  std::istringstream text(read_whole(posix_storage(), path).value());
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);)
    if (!line.starts_with('#')) lines.push_back(line);
  return lines;
}

inline ReadColmap read_colmap(const std::string& folder) {
  ReadColmap model;
  ReadCamera lens;
  const auto cameras = data_lines(folder + "/cameras.txt");
  REQUIRE(cameras.size() == 1);
  std::string word;
  int id = 0, camera_id = 0;
  std::istringstream(cameras[0]) >> camera_id >> word >> model.width >> model.height >> lens.fx >> lens.fy >>
      lens.cx >> lens.cy;
  REQUIRE(word == "PINHOLE");
  const auto images = data_lines(folder + "/images.txt");
  REQUIRE(images.size() % 2 == 0);
  for (std::size_t i = 0; i < images.size(); i += 2) {
    std::istringstream line(images[i]), seen(images[i + 1]);
    double w = 0, x = 0, y = 0, z = 0;
    int camera = 0;
    ReadColmap::Image image{"", lens, {}};
    line >> id >> w >> x >> y >> z >> image.camera.t[0] >> image.camera.t[1] >> image.camera.t[2] >> camera >>
        image.name;
    REQUIRE_FALSE(line.fail());
    REQUIRE(camera == camera_id);
    REQUIRE(w * w + x * x + y * y + z * z == Approx(1).epsilon(1e-9));
    const double R[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    std::memcpy(image.camera.R, R, sizeof R);
    for (ReadColmap::Sighting s; seen >> s.at.u_px >> s.at.v_px >> s.point;) image.sightings.push_back(s);
    REQUIRE(model.images.emplace(id, image).second);
  }
  for (const std::string& text : data_lines(folder + "/points3D.txt")) {
    std::istringstream line(text);
    ReadColmap::Point point;
    double error = 0;
    line >> id >> point.p_world.x >> point.p_world.y >> point.p_world.z >> point.rgb[0] >> point.rgb[1] >>
        point.rgb[2] >> error;
    REQUIRE_FALSE(line.fail());
    for (std::pair<int, int> seen; line >> seen.first >> seen.second;) point.track.push_back(seen);
    REQUIRE(model.points.emplace(id, point).second);
  }
  return model;
}

// vision.middlebury.edu/flow/code/flow-code/README.txt
struct ReadFlow {
  std::int32_t width = 0, height = 0;
  std::vector<float> uv;  // [height, width, 2]

  float u(int y, int x) const { return uv[2 * static_cast<std::size_t>(y * width + x)]; }
  float v(int y, int x) const { return uv[2 * static_cast<std::size_t>(y * width + x) + 1]; }
  bool known(int y, int x) const { return std::abs(u(y, x)) <= 1e9f && std::abs(v(y, x)) <= 1e9f; }
};
inline ReadFlow read_flow(const std::string& path) {
  const std::string bytes = read_whole(posix_storage(), path).value();
  REQUIRE(bytes.size() > 12);
  float tag = 0;
  ReadFlow flow;
  std::memcpy(&tag, bytes.data(), 4);
  std::memcpy(&flow.width, bytes.data() + 4, 4);
  std::memcpy(&flow.height, bytes.data() + 8, 4);
  REQUIRE(tag == 202021.25f);
  const std::size_t values = 2 * static_cast<std::size_t>(flow.width) * static_cast<std::size_t>(flow.height);
  REQUIRE(bytes.size() == 12 + 4 * values);
  flow.uv.resize(values);
  std::memcpy(flow.uv.data(), bytes.data() + 12, 4 * values);
  return flow;
}

}  // namespace hdrcam::test
