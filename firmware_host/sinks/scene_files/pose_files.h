// The sinks of --transforms and --colmap: they collect the pictures that a run leaves, with their poses, and
// write one model when it ends (transforms_json.h, colmap_text.h). A frame without a pose, or whose pose is
// lost, is left out, as is one whose picture the run has not written in the end, also where one of an earlier
// run has its name; so are frames after the first 100 000, which no such tool takes. Where tracking began
// anew, a model has the poses of one world: of that with most pictures, of these the newest. Points are those
// of its newest 32 frames that have any; while the run goes on they are kept of the three largest worlds.
// Thread-bound.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// Where the run leaves its pictures: patterns for one file per frame.
struct PicturePatterns {
  std::string pictures;  // "" where it leaves none
  std::string depths;    // of depth_pictures.h; "" for none
};

// The pictures that the poses of `flag` are of. Errors: Invalid where the run leaves none.
Result<FramePattern> pictures_of(std::string_view flag, const PicturePatterns& patterns);

// Those of --colmap: no blank may be in their names, at which images.txt is split. Errors: Invalid where one
// is; those of pictures_of.
Result<FramePattern> pictures_of_colmap(const PicturePatterns& patterns);

// path: of the file; model: of the folder. The storage outlives the sinks. Errors: those of pictures_of and
// pictures_of_colmap; those of the disk. emit() fails where a pose has no lens, conclude() where no frame had
// a pose.
Result<std::unique_ptr<FrameSink>> create_transforms(Storage& storage, const std::string& path,
                                                     const PicturePatterns& patterns);
Result<std::unique_ptr<FrameSink>> create_colmap(Storage& storage, const std::string& model,
                                                 const PicturePatterns& patterns);

}  // namespace hdrcam
