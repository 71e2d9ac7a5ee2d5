// Pictures that another camera left: videos of any codec that FFmpeg decodes, stills, and raw stills. Each
// frame leaves as the codes of its file, RGB or mono, with its time and, where the file says one, its
// exposure, and upright where the file states how it is turned. Y'CbCr becomes R'G'B' with the matrix and
// range that the file states; the transfer curve stays, for the response is learned anyway. Readers are
// thread-bound; the storage outlives them.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/footage/exif_time.h"
#include "hal/footage/picture_file.h"
#include "hal/storage.h"

namespace hdrcam {

// A file that was not whole, and what it lacks.
struct FootageLosses {
  std::string path;
  PictureLosses lost;
};

// How the pictures of a file were stored; applied to them.
struct OrientedFile {
  std::string path;
  Orientation orientation = Orientation::Upright;
};

class FootageReader {
 public:
  virtual ~FootageReader() = default;

  // Size, depth and layout of all frames, upright; linear where the codes are those of the sensor. The lens
  // is that of the first still, by its focal length for 35 mm film. The name is that of a video's file
  // without its extension; of stills the camera's model, where all so far state it, else "".
  virtual const CameraFacts& camera() const = 0;
  // In one clause for people: "h264, yuv420p".
  virtual std::string about() const = 0;
  // The first that a file states, so far, other than BT.709's: "bt2020"; "": none. They are not converted.
  virtual const std::string& primaries() const = 0;
  // The first file of each orientation so far.
  virtual const std::vector<OrientedFile>& orientations() const = 0;
  // Whether a file states, so far, a turn for display that is no multiple of 90 degrees, which is not
  // applied.
  virtual bool oblique() const = 0;
  // The next frame; false at the end. Its facts: the number within the footage, the time since its beginning,
  // and the exposure with its source, Unknown where the file says none. Frames of a video that are not whole
  // are left out (losses). Errors: Corrupt for a damaged still; Truncated for a video that ends before its
  // first frame does; SizeChanged, Unsupported.
  virtual Result<bool> next(RawFrame& frame) = 0;
  // When the frame of the last next() was taken, of stills that say it; not of a file that is timed.
  virtual std::optional<ExifTime> taken() const = 0;
  // Which factors of the exposure its file states, beside the time.
  virtual ExifFactors factors() const = 0;
  // The file of that frame, whether it is a still, and whether it says itself when its frames are.
  virtual const std::string& path() const = 0;
  virtual bool still() const = 0;
  virtual bool timed() const = 0;
  // The files so far that were not whole; complete at the end.
  virtual const std::vector<FootageLosses>& losses() const = 0;
};

// Whether two files have neighbouring numbers and names that are alike else: IMG_0009.JPG, IMG_0010.JPG.
bool is_next_number(const std::string& file, const std::string& next);
// Whether the second, of a name that is alike else, has the lower number: IMG_10.JPG, IMG_2.JPG, as a shell
// puts them.
bool is_earlier_number(const std::string& file, const std::string& next);

// The pictures of these files, one after the other, as one clip. framerate_hz: of stills, which do not say
// it; 0: 30. Errors: NotFound, Permission; NotRecording for what is neither video nor picture; Unsupported,
// also for pictures that no recording can hold; Truncated; SizeChanged.
Result<std::unique_ptr<FootageReader>> open_footage(Storage& storage, std::vector<std::string> files,
                                                    double framerate_hz);

// Whether a file is a still by its name, as those in a folder are told from videos.
bool is_still(const std::string& path);
// Whether a file is a still, a raw still or a video by its name, in letters of either case.
bool is_footage(const std::string& path);

// The pictures and videos in a folder, by name, numbers in their order (IMG_9 before img_10). Errors:
// NotFound where there are none, which names a folder below that holds some; Permission where the folder
// cannot be read.
Result<std::vector<std::string>> footage_in(const std::string& folder);
// The pictures in it of kinds that are read only where they are named, or not at all, as HEIC, by name.
std::vector<std::string> other_pictures_in(const std::string& folder);
// The links in it that are named like pictures and videos, and whose files are not there, by name.
std::vector<std::string> broken_links_in(const std::string& folder);

}  // namespace hdrcam
