// Reading and writing recordings: raw frames and every fact about them. The container (lossless pictures in
// Matroska, facts in a JSON data track) is specified in docs/recording.md. The reader and the writer are
// thread-bound; the storage outlives them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// How pixels are compressed; both are without loss. Huffyuv takes a fifth of the time, FFV1 a fifth less
// space.
enum class RecordingCodec { Huffyuv, Ffv1 };

std::string_view name(RecordingCodec codec);

class RecordingWriter {
 public:
  virtual ~RecordingWriter() = default;
  // Appends one whole frame before it returns. Errors: SizeChanged; Invalid for a code beyond `bits`, and for
  // facts that a reader would refuse (hal/core/sound_facts.h); NoSpace, Io.
  virtual Result<void> append(const RawFrame& frame) = 0;
  // Writes the end record and the index. Without them the file is readable up to its last whole cluster. A
  // recording without a frame that was to replace another leaves no file.
  virtual Result<void> finish() = 0;
};

// What a damaged frame means to whoever reads: the end with an error, or one frame less.
enum class Damage { Ends, IsSkipped };

// Frames of a damaged recording that could not be read.
struct LeftOut {
  static constexpr std::size_t kPlaces = 8;

  std::uint64_t count = 0;
  std::vector<std::uint64_t> places;  // the first of them: 0, 1, 2 .. in the file
  std::string reason;                 // of the first; with a count of 0: why the file is damaged all the same
  bool end_is_missing = false;  // with it how many frames there were: some behind the last one may be lost

  // "2 damaged frames left out: 20, 21 (the checksum ..)"; empty for a sound file.
  std::string sentence() const;
};

class RecordingReader {
 public:
  virtual ~RecordingReader() = default;
  virtual const CameraFacts& camera() const = 0;
  // Of its pixels; where it has none, what a copy gets unless told otherwise.
  virtual RecordingCodec codec() const { return RecordingCodec::Huffyuv; }
  // Frames in the index, or nullopt where the file was truncated before the index was written.
  virtual std::optional<int> frame_count() const = 0;
  // The next frame; nullopt at the end. room: a frame that is done with, of any size, whose memory the next
  // one may take; it is lost in any case. Truncated where the file was cut short, after all its whole frames.
  virtual Result<std::optional<RawFrame>> next(RawFrame room) = 0;
  Result<std::optional<RawFrame>> next() { return next({}); }
  // Like next(), but the pixels are only checked, not decoded: for listing a recording.
  virtual Result<std::optional<FrameFacts>> next_facts();
  // The file of its own that holds the frame with this number, as the still that was imported; "": none.
  virtual std::string file_of(std::uint64_t /*sequence*/) const { return ""; }
  // With Damage::IsSkipped, of the frames so far.
  virtual const LeftOut& left_out() const;
  // Of another recording that was put behind this one, in the same file; behind one that was cut it is only
  // known at the end. It is not read.
  virtual std::uint64_t bytes_behind() const { return 0; }
};

// "another recording, of 1234 bytes, follows this one in the file and is not read; .."; "" for none.
std::string told_of_behind(const RecordingReader& reader);
// What to say of a recording that was read: of frames that were left out, of another recording behind it.
std::vector<std::string> warnings_of(const RecordingReader& reader);
// Corrupt: of a recording that was read to its end and gave nothing to write.
Error no_whole_frame(const std::string& path);

// how: Replace: the file gets its name when its first frame is whole; until then an earlier file stays.
// Errors: Exists where a file exists that may not be replaced; Permission, also for a device or a FIFO;
// NoSpace, Io; Invalid for a size or bit depth that the container cannot hold. Once a write has failed, every
// later call returns the same error.
Result<std::unique_ptr<RecordingWriter>> create_recording(Storage& storage, const std::string& path,
                                                          const CameraFacts& camera,
                                                          Creation how = Creation::New,
                                                          RecordingCodec codec = RecordingCodec::Huffyuv);
// Errors: NotFound, Permission, NotRecording, Corrupt, Truncated (cut before the first whole frame),
// Unsupported (a newer format).
Result<std::unique_ptr<RecordingReader>> open_recording(Storage& storage, const std::string& path,
                                                        Damage damage = Damage::Ends);

}  // namespace hdrcam
