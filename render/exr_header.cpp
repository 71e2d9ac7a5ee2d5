#include "render/exr_header.h"

#include <ImfHeader.h>
#include <ImfRational.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTimeCode.h>

#include "hal/core/geometry.h"
#include "hal/recording/nominal_rate.h"

namespace hdrcam {
namespace {

// OpenEXR's camera has x right, y up and z forward, of ours y is down (ImfStandardAttributes.h).
constexpr double kSignOfAxis[3] = {1, -1, 1};

// OpenEXR multiplies row vectors from the left, p_camera = p_world * m: but for the sign of y, m is the
// transpose of T_camera_world.
Imath::M44f world_to_camera(const PoseMatrix& T_world_camera) {
  const RigidTransform T_camera_world = transform_of(T_world_camera).inverse();
  Imath::M44f m;
  for (int axis = 0; axis < 3; ++axis) {  // + 0.0: never -0
    for (int k = 0; k < 3; ++k)
      m[k][axis] = static_cast<float>(kSignOfAxis[axis] * T_camera_world.R(axis, k) + 0.0);
    m[3][axis] = static_cast<float>(kSignOfAxis[axis] * T_camera_world.t[axis] + 0.0);
  }
  return m;
}

PoseMatrix world_from_camera(const Imath::M44f& m) {
  RigidTransform T_camera_world;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k)
      T_camera_world.R(axis, k) = kSignOfAxis[axis] * static_cast<double>(m[k][axis]);
    T_camera_world.t[axis] = kSignOfAxis[axis] * static_cast<double>(m[3][axis]);
  }
  return pose_matrix_of(T_camera_world.inverse());
}

Imath::V2f library_point(const std::array<float, 2>& xy) { return {xy[0], xy[1]}; }
std::array<float, 2> point(const Imath::V2f& xy) { return {xy.x, xy.y}; }

Imf::Rational frames_per_second(double hz) {
  const NominalRate rate = nominal_rate(hz);
  return {rate.numerator, rate.denominator};
}

}  // namespace

void add_attributes(const ExrAttributes& a, Imf::Header& header) {
  if (a.exposure_s) Imf::addExpTime(header, static_cast<float>(*a.exposure_s));
  if (a.framerate_hz) Imf::addFramesPerSecond(header, frames_per_second(*a.framerate_hz));
  if (a.white_cd_m2) Imf::addWhiteLuminance(header, static_cast<float>(*a.white_cd_m2));
  if (a.chromaticities) {
    const Chromaticities& c = *a.chromaticities;
    Imf::addChromaticities(header, {library_point(c.red), library_point(c.green), library_point(c.blue),
                                    library_point(c.white)});
  }
  if (a.time_code) {
    const TimeCode& t = *a.time_code;
    Imf::addTimeCode(header, Imf::TimeCode(t.hours, t.minutes, t.seconds, t.frame));
  }
  if (a.T_world_camera) Imf::addWorldToCamera(header, world_to_camera(*a.T_world_camera));
  if (!a.owner.empty()) Imf::addOwner(header, a.owner);
  if (!a.comments.empty()) Imf::addComments(header, a.comments);
  for (const auto& [name, text] : a.texts) header.insert(name, Imf::StringAttribute(text));
}

ExrAttributes attributes_of(const Imf::Header& header) {
  ExrAttributes a;
  if (Imf::hasExpTime(header)) a.exposure_s = Imf::expTime(header);
  if (Imf::hasFramesPerSecond(header)) a.framerate_hz = static_cast<double>(Imf::framesPerSecond(header));
  if (Imf::hasWhiteLuminance(header)) a.white_cd_m2 = Imf::whiteLuminance(header);
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    a.chromaticities = Chromaticities{point(c.red), point(c.green), point(c.blue), point(c.white)};
  }
  if (Imf::hasTimeCode(header)) {
    const Imf::TimeCode& t = Imf::timeCode(header);
    a.time_code = TimeCode{t.hours(), t.minutes(), t.seconds(), t.frame()};
  }
  if (Imf::hasWorldToCamera(header)) a.T_world_camera = world_from_camera(Imf::worldToCamera(header));
  if (Imf::hasOwner(header)) a.owner = Imf::owner(header);
  if (Imf::hasComments(header)) a.comments = Imf::comments(header);
  for (auto entry = header.begin(); entry != header.end(); ++entry)
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute());
        text != nullptr && std::string_view(entry.name()).starts_with("hdrcam."))
      a.texts[entry.name()] = text->value();
  return a;
}

}  // namespace hdrcam
