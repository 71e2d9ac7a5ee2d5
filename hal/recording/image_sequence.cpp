#include "hal/recording/image_sequence.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "hal/core/counted.h"
#include "hal/recording/png_image.h"

namespace hdrcam {
namespace {

// Where 16-bit samples hold their codes: in the upper bits or scaled to the full range, as they should; in
// the lower bits, where no sample is larger than a code; or neither.
enum class CodePlace { Upper, Lower, Neither };

// 16-bit samples to codes, which count only if they were in the upper bits.
CodePlace to_codes(Image<std::uint16_t>& samples, int bits) {
  const int shift = 16 - bits, largest = (1 << bits) - 1;
  bool exact = true, below = true;
  for (std::uint16_t& sample : samples.samples()) {
    below = below && sample <= largest;
    const int code = sample >> shift;
    const bool shifted = code << shift == sample;
    const bool scaled = std::abs(std::int64_t{sample} * largest - std::int64_t{code} * 65535) * 2 <= largest;
    exact = exact && (shifted || scaled);
    sample = static_cast<std::uint16_t>(code);
  }
  if (exact) return CodePlace::Upper;
  return below ? CodePlace::Lower : CodePlace::Neither;
}

// What is wrong with codes that are not in the upper bits, and what to do: the end of a sentence.
std::string misplaced(CodePlace place, int bits) {
  if (place == CodePlace::Lower)
    return fmt::format(
        "has its {}-bit codes in the lower bits of 16; shift them up by {} (docs/recording.md, Bits)", bits,
        16 - bits);
  return fmt::format(
      "has samples that are no {}-bit codes, neither in the upper bits of 16 nor scaled to 16; set 'bits' to "
      "the bits that they use, 16 for all (docs/recording.md, Bits)",
      bits);
}

void to_samples(Image<std::uint16_t>& codes, int bits) {
  for (std::uint16_t& code : codes.samples()) code = static_cast<std::uint16_t>(code << (16 - bits));
}

}  // namespace

Result<ImageSequence> ImageSequence::open(Storage& storage, const std::string& path, ClipReach reach) {
  const bool is_file = path.ends_with(".json");
  const std::filesystem::path file =
      is_file ? std::filesystem::path(path) : std::filesystem::path(path) / ImageSequence::kFile;
  ImageSequence sequence(storage, file.parent_path().string(), reach);
  std::string text = TRY(read_whole(storage, file.string()));
  sequence.clip_ = TRY(clip_from_json(std::move(text), file.string()));
  const std::string folder = sequence.folder_.empty() ? "." : sequence.folder_;
  sequence.real_folder_ = TRY(storage.look_at(folder)).real_path;
  if (!sequence.clip_.layout_is_named) {
    const PngImage first = TRY(sequence.load(0));
    sequence.clip_.camera.layout = first.samples.channels() == 3 ? PixelLayout::Rgb : PixelLayout::Mono;
  }
  return sequence;
}

std::string ImageSequence::path_of(int index) const {
  return (std::filesystem::path(folder_) / clip_.frames[static_cast<std::size_t>(index)].file).string();
}

// Somebody else's clip may name any file of this machine: a picture outside is refused whether it is there or
// not, and a FIFO is not waited for.
Result<void> ImageSequence::check_reach(const std::string& path) const {
  const FileFacts there = TRY(storage_->look_at(path));
  if (there.kind == FileKind::Other)
    return Error{ErrorCode::Permission, fmt::format("'{}' is a device or a FIFO, not a PNG", path)};
  const std::filesystem::path way = std::filesystem::path(there.real_path).lexically_relative(real_folder_);
  if (reach_ == ClipReach::BelowFolder && (way.empty() || *way.begin() == ".."))
    return Error{ErrorCode::Permission,
                 fmt::format("'{}' is outside the clip's folder; --allow-outside reads it", path)};
  return {};
}

Result<PngImage> ImageSequence::load(int index) const {
  const std::string path = path_of(index);
  const auto checked = check_reach(path);
  auto image = checked ? read_png(*storage_, path, clip_.camera.width, clip_.camera.height)
                       : Result<PngImage>(checked.error());
  if (image) return image;
  const Error& error = image.error();
  return Error{error.code, fmt::format("frame {}: {}", index, error.message), error.sys_errno};
}

Result<RawFrame> ImageSequence::read(int index) const {
  const CameraFacts& camera = clip_.camera;
  PngImage image = TRY(load(index));
  const int found = image.samples.channels(), expected = channels(camera.layout);
  if (found != expected)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("frame {}: '{}' has {}, expected {} ({})", index, path_of(index),
                             counted(found, "channel"), expected, name(camera.layout))};
  if (image.bits_per_sample < camera.bits)
    return Error{ErrorCode::Invalid,
                 fmt::format("frame {}: '{}' has 8 bits a sample, the clip states {}; set 'bits' to 8", index,
                             path_of(index), camera.bits)};
  if (image.bits_per_sample == 16)
    if (const CodePlace place = to_codes(image.samples, camera.bits); place != CodePlace::Upper)
      return Error{ErrorCode::Invalid,
                   fmt::format("frame {}: '{}' {}", index, path_of(index), misplaced(place, camera.bits))};
  return RawFrame{clip_.frames[static_cast<std::size_t>(index)].facts, std::move(image.samples)};
}

namespace {

class ClipReader : public RecordingReader {
 public:
  explicit ClipReader(ImageSequence clip) : clip_(std::move(clip)) {}
  const CameraFacts& camera() const override { return clip_.camera(); }
  std::optional<int> frame_count() const override { return clip_.frame_count(); }
  Result<std::optional<RawFrame>> next(RawFrame /*room*/) override {
    if (at_ == clip_.frame_count()) return std::optional<RawFrame>();
    return std::optional<RawFrame>(TRY(clip_.read(at_++)));
  }
  std::string file_of(std::uint64_t sequence) const override {
    for (int i = 0; i < clip_.frame_count(); ++i)
      if (clip_.facts(i).sequence == sequence) return clip_.path_of(i);
    return "";
  }

 private:
  const ImageSequence clip_;
  int at_ = 0;
};

}  // namespace

std::unique_ptr<RecordingReader> reader_of(ImageSequence clip) {
  return std::make_unique<ClipReader>(std::move(clip));
}

Result<ImageSequenceWriter> ImageSequenceWriter::create(Storage& storage, const std::string& folder,
                                                        const CameraFacts& camera, Creation how) {
  const std::string file = folder + "/" + ImageSequence::kFile;
  const auto held = storage.open(file);
  if (!held && held.error().code != ErrorCode::NotFound) return held.error();
  if (held && how == Creation::New)
    return Error{ErrorCode::Exists,
                 fmt::format("'{}' already holds a clip; name another folder or remove it", folder)};
  TRY(storage.make_directories(folder + "/" + ImageSequence::kPictures));
  ImageSequenceWriter writer(storage, folder);
  writer.replaces_ = held.ok();
  writer.clip_.camera = camera;
  return writer;
}

Result<void> ImageSequenceWriter::append(const RawFrame& frame) {
  const CameraFacts& camera = clip_.camera;
  if (frame.codes.channels() != channels(camera.layout) || frame.codes.rows() != camera.height ||
      frame.codes.cols() != camera.width)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("frame {} is {}x{}, the clip is {}x{}", clip_.frames.size(), frame.codes.cols(),
                             frame.codes.rows(), camera.width, camera.height)};
  if (replaces_) TRY(storage_->remove(folder_ + "/" + ImageSequence::kFile));
  replaces_ = false;
  PngImage image{camera.bits > 8 ? 16 : 8, frame.codes.clone()};
  if (camera.bits > 8) to_samples(image.samples, camera.bits);
  const std::string file = fmt::format("{}/{:04}.png", ImageSequence::kPictures, clip_.frames.size());
  TRY(write_png(*storage_, folder_ + "/" + file, image));
  clip_.frames.push_back({file, frame.facts});
  return {};
}

std::string ImageSequenceWriter::last_path() const { return folder_ + "/" + clip_.frames.back().file; }

// A power cut leaves images without a clip.json, never one that claims images which are not there.
Result<void> ImageSequenceWriter::sync_images() {
  for (const auto& frame : clip_.frames) {
    const auto image = TRY(storage_->open(folder_ + "/" + frame.file));
    TRY(image->sync());
  }
  return sync_name(*storage_, last_path());
}

Result<void> ImageSequenceWriter::finish() {
  if (clip_.frames.empty()) return {};
  TRY(sync_images());
  const std::string text = clip_to_json(clip_);
  return write_whole(*storage_, folder_ + "/" + ImageSequence::kFile, std::as_bytes(std::span(text)));
}

}  // namespace hdrcam
