// A clip as a folder of PNG images with a clip.json (docs/recording.md): read one frame at a time, and
// written so that it reads back the same, bit by bit. Thread-bound.
#pragma once

#include <memory>
#include <string>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/recording/clip_json.h"
#include "hal/recording/recording.h"
#include "hal/storage.h"

namespace hdrcam {

struct PngImage;

// Which images a clip.json may name.
enum class ClipReach {
  BelowFolder,  // of the clip.json, symbolic links followed
  Anywhere,
};

class ImageSequence {
 public:
  static constexpr const char* kFile = "clip.json";
  static constexpr const char* kPictures = "ldr";  // folder of the images that ImageSequenceWriter writes

  // path: of the clip.json, or of the folder that holds it. The storage outlives the sequence.
  // Errors: those of clip_from_json and, for the first image, of read.
  static Result<ImageSequence> open(Storage& storage, const std::string& path,
                                    ClipReach reach = ClipReach::BelowFolder);

  const CameraFacts& camera() const { return clip_.camera; }
  std::string path() const { return folder_.empty() ? kFile : folder_ + "/" + kFile; }
  std::string path_of(int index) const;  // of an image
  int frame_count() const { return static_cast<int>(clip_.frames.size()); }
  const FrameFacts& facts(int index) const { return clip_.frames[static_cast<std::size_t>(index)].facts; }
  // Errors: NotFound, Permission (also for what is outside the reach, a device or a FIFO); Corrupt (a damaged
  // PNG); SizeChanged (another size, or grey among RGB); Invalid (a bit would be lost); Unsupported. Messages
  // name the frame, the file and the value.
  Result<RawFrame> read(int index) const;

 private:
  ImageSequence(Storage& storage, std::string folder, ClipReach reach)
      : storage_(&storage), folder_(std::move(folder)), reach_(reach) {}
  Result<PngImage> load(int index) const;
  Result<void> check_reach(const std::string& path) const;

  Storage* storage_;
  std::string folder_;
  ClipReach reach_;
  std::string real_folder_;  // without symbolic links
  Clip clip_;
};

// A clip, read frame by frame like a recording.
std::unique_ptr<RecordingReader> reader_of(ImageSequence clip);

class ImageSequenceWriter {
 public:
  // Makes the folder. how: Replace keeps the clip.json of an earlier clip until the first image. Errors:
  // Exists where it already holds a clip and none is to be replaced; Permission. The storage outlives the
  // writer.
  static Result<ImageSequenceWriter> create(Storage& storage, const std::string& folder,
                                            const CameraFacts& camera, Creation how = Creation::New);

  // Writes the whole image; the first one takes the place of an earlier clip. Errors: SizeChanged,
  // Permission, NoSpace, Io.
  Result<void> append(const RawFrame& frame);
  std::string last_path() const;  // of the image written last
  // Writes the clip.json once the images are on the disk; until then the folder holds images but no clip.
  // Without an image it writes nothing, and an earlier clip stays.
  Result<void> finish();

 private:
  ImageSequenceWriter(Storage& storage, std::string folder)
      : storage_(&storage), folder_(std::move(folder)) {}
  Result<void> sync_images();

  Storage* storage_;
  std::string folder_;
  bool replaces_ = false;  // the clip.json of an earlier clip is still there
  Clip clip_;
};

}  // namespace hdrcam
