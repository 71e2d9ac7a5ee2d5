// What is known of the black level of a camera's codes while the fit has not estimated the response: what
// somebody states, or an upper bound that the pictures narrow. It decides with which response the proof of
// exposures compares pictures (photometry.h). Value type, thread-bound; no allocation.
#pragma once

#include <optional>

#include "capture/photometry.h"
#include "capture/sensor_table.h"
#include "hal/camera.h"

namespace hdrcam {

class RawBlack {
 public:
  // `user`: stated by the user, `table`: the camera's sensor in the table of known ones, whose black level
  // holds for raw codes. linear: the codes are raw.
  RawBlack(const std::optional<BlackLevel>& user, const CameraCapabilities& camera,
           const std::optional<KnownSensor>& table, bool linear);

  // Stated by the user, else by the camera, else by the table.
  const std::optional<BlackLevel>& stated() const { return stated_; }
  // Of one frame: stated by the user, else with the frame, else as for all.
  const std::optional<BlackLevel>& stated(const std::optional<BlackLevel>& with_frame) const {
    return with_frame && !by_user_ ? with_frame : stated_;
  }
  // Raw codes, and nobody states it.
  bool unreported() const { return linear_ && !stated_; }
  // Takes the first level that comes with a frame for all frames, where nobody else states one and the
  // response was not learned otherwise. Returns whether it did: first_response() is then another one.
  bool adopt(const std::optional<BlackLevel>& with_frame);

  // For the first pictures.
  PhotometricResponse first_response() const;
  // No pixel is darker than black, so the darkest site of a picture bounds an unreported black level. The
  // response for later pictures, where the bound fell so far that earlier ones must be discarded.
  std::optional<PhotometricResponse> narrow(const PhotometricSignature& picture);
  // The response was learned otherwise: nothing is narrowed any more.
  void settle() { most_.reset(); }

 private:
  std::optional<BlackLevel> stated_;
  bool by_user_, linear_;
  std::optional<float> most_;  // codes of 255: upper bound of an unreported black level
};

}  // namespace hdrcam
