// A scene at one instant, seen by its camera: rays go out, hits come back. A ray is the point (x, y) of the
// plane one metre ahead, so that its parameter is the depth itself (camera z, metres). pose_at() fills a view
// without allocating after the first time; the other methods are reentrant.
#pragma once

#include <vector>

#include "hal/sim/scene.h"

namespace hdrcam {

struct Hit {
  float depth_m = 0;  // camera z
  int object = 0;     // index into Scene::objects; the dome catches every ray
  int part = 0;       // face of a box or of a ball's painting: neighbours of one part share a smooth picture
  Vec3 point;         // in the object's own coordinates, before its pulse
  Vec3 normal;        // there, facing the ray; not of the dome
};

class View {
 public:
  void pose_at(const Scene& scene, double time_s);

  Hit cast(Vec2 ray) const;
  // footprint: width of the sample, in rays, for the filter of the textures.
  Colour radiance(const Hit& hit, float footprint) const;
  // Where a point of an object is seen: the ray, and its depth (<= 0: behind the camera).
  Vec3 project(int object, Vec3 point) const;

  const Pose& camera() const { return camera_; }

 private:
  struct Seen {
    Mat3 R_object_camera;
    Vec3 eye;                              // the camera, in the object's coordinates
    Vec3 centre;                           // the object, in camera axes
    float size = 1;                        // pulse
    float x0 = 0, x1 = 0, y0 = 0, y1 = 0;  // rays outside never meet it
  };
  struct Light {
    Vec3 position;  // world
    Colour power;   // irradiance at one metre
  };
  static void bound(Seen& seen, float radius);
  Colour lit(const Hit& hit, Colour albedo) const;

  const Scene* scene_ = nullptr;
  Pose camera_;
  std::vector<Seen> seen_;
  std::vector<PosedObject> posed_;
  std::vector<Light> lights_;
};

}  // namespace hdrcam
