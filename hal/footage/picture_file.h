// One file of footage, whatever its kind: a video or a picture that FFmpeg decodes (video_file.h), or the raw
// still of a camera (raw_still.h). Thread-bound.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/footage/exif_exposure.h"
#include "hal/footage/exif_time.h"
#include "hal/footage/orientation.h"

namespace hdrcam {

// The form of all frames of a file, which are upright; known once the first has been read.
struct PictureFileFacts {
  int bits = 8;
  PixelLayout layout = PixelLayout::Rgb;
  bool linear = false;
  int white = 0;               // the file's code from which on all is clipped; 0: the largest
  std::string format;          // "h264, yuv420p"
  bool still = false;          // a file of one picture
  double framerate_hz = 0;     // 0 of a still, and of a video that states none
  bool timed = false;          // it says when each frame is, not a rate alone
  double focal_35mm_mm = 0;    // focal length that is equivalent for 35 mm film, of stills; 0: none is stated
  std::string model = {};      // "Canon EOS R5", as EXIF states it; "": it does not
  std::string primaries = {};  // other than BT.709's, "bt2020"; "": none are stated
  Orientation orientation = Orientation::Upright;  // as stated for the frame last read, and applied to it
  bool oblique = false;  // states a turn for display that is no multiple of 90 degrees, which is not applied
  std::optional<ChannelGains> white_balance = {};  // as the camera states it for its codes
};

// Make and model of a camera, without the blanks that some put behind them; "": no model is stated.
std::string camera_model(std::string_view make, std::string_view model);

// What a file lacks of the pictures that it should hold.
struct PictureLosses {
  int damaged = 0;  // that do not decode, or are predicted from such
  int missing = 0;  // behind the end of a file that was cut
};

class PictureFile {
 public:
  virtual ~PictureFile() = default;

  virtual const PictureFileFacts& facts() const = 0;
  // The next whole frame; false at the end. Its timestamp is the time in the file; its exposure what the file
  // says. Errors: Corrupt for a damaged still, and where no frame is whole; Truncated for a video that ends
  // before its first one does; SizeChanged, Unsupported.
  virtual Result<bool> next(RawFrame& frame) = 0;
  // When the frame of the last next() was taken, of stills that say it; not of a file that is timed.
  virtual std::optional<ExifTime> taken() const { return std::nullopt; }
  // Which factors of the exposure its file states, beside the time.
  virtual ExifFactors factors() const { return {}; }
  // Of what was read so far; complete at the end.
  virtual PictureLosses losses() const { return {}; }
};

}  // namespace hdrcam
