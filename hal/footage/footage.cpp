#include "hal/footage/footage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "hal/core/file_extension.h"
#include "hal/core/folder_listing.h"
#include "hal/core/parse_number.h"
#include "hal/core/sound_facts.h"
#include "hal/footage/raw_still.h"
#include "hal/footage/video_file.h"
#include "hal/recording/image_sequence.h"

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualFramerate_hz = 30;
constexpr Duration kLatest = std::chrono::years(100);  // of a frame; sums of two still fit 64 bits

// What is looked at in a folder; a file that is named is opened whatever it is called.
constexpr std::string_view kStills[] = {".jpeg", ".jpg", ".png", ".tif", ".tiff"};
constexpr std::string_view kOtherPictures[] = {".avif", ".bmp", ".crw", ".gpr", ".heic", ".heif", ".hif",
                                               ".jp2",  ".jpe", ".jxl", ".mpo", ".webp", ".x3f"};
constexpr std::string_view kVideos[] = {".avi", ".m2ts", ".m4v", ".mkv",  ".mov", ".mp4",
                                        ".mts", ".mxf",  ".nut", ".webm", ".ts",  ".y4m"};

bool has_one_of(const std::string& path, std::span<const std::string_view> extensions) {
  return std::ranges::find(extensions, lower_extension(path)) != extensions.end();
}

// Such as "._IMG_0.JPG", which some systems write beside each file of a card.
bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// By letters, of either case as on a camera's card, and numbers by their value; names that differ in case or
// leading zeros alone by their characters.
bool before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto number = [&digit](const std::string& text, std::size_t& at) {
    while (at < text.size() && text[at] == '0') ++at;
    const std::size_t begin = at;
    while (at < text.size() && digit(text[at])) ++at;
    return std::string_view(text).substr(begin, at - begin);
  };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const std::string_view x = number(a, i), y = number(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (lower(a[i]) != lower(b[j])) {
      return lower(a[i]) < lower(b[j]);
    } else {
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

bool is_other_picture(const std::string& path) { return has_one_of(path, kOtherPictures); }

bool is_regular_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_broken_link(const fs::path& path) {
  std::error_code ignored;
  return fs::is_symlink(path, ignored) && !fs::exists(path, ignored);
}

// What the listing has of this kind with such a name, numbers in their order.
template <class IsKind, class IsNamed>
std::vector<std::string> files_of(const FolderListing& listing, const IsKind& is_kind,
                                  const IsNamed& is_named) {
  std::vector<std::string> files;
  for (const fs::path& path : listing.paths())
    if (is_named(path.string()) && !is_hidden(path) && is_kind(path)) files.push_back(path.string());
  std::ranges::sort(files, before);
  return files;
}

std::vector<std::string> folders_in(const FolderListing& listing) {
  return files_of(listing, is_folder, [](const std::string&) { return true; });
}

bool holds_footage(const FolderListing& listing) {
  const auto is_clip = [](const std::string& path) {
    return fs::path(path).filename() == ImageSequence::kFile;
  };
  return !files_of(listing, is_regular_file, is_footage).empty() ||
         !files_of(listing, is_regular_file, is_clip).empty();
}

// The nearest folder below it that holds footage or a clip; "": none does, as far as was looked.
std::string folder_of_footage(const FolderListing& listing) {
  constexpr int kDepth = 4;                    // of a card: PRIVATE/AVCHD/BDMV/STREAM
  constexpr std::size_t kMostLookedAt = 1000;  // folders: nobody waits for a whole disk
  std::vector<std::string> folders = folders_in(listing);
  std::size_t looked_at = 0;
  for (int depth = 1; depth <= kDepth; ++depth) {
    std::vector<std::string> below;
    for (const std::string& folder : folders) {
      if (++looked_at > kMostLookedAt) return "";
      const FolderListing inside(folder);
      if (holds_footage(inside)) return folder;
      for (std::string& deeper : folders_in(inside)) below.push_back(std::move(deeper));
    }
    folders = std::move(below);
  }
  return "";
}

// What to do about a folder without footage.
std::string where_else(const FolderListing& listing) {
  if (const std::string below = folder_of_footage(listing); !below.empty())
    return fmt::format("such are in '{}'", below);
  const std::vector<std::string> others = files_of(listing, is_regular_file, is_other_picture);
  if (others.empty()) return "name files of other kinds one by one";
  return fmt::format("name files of other kinds, such as '{}', one by one", others.front());
}

struct NumberedName {
  std::string text;  // the path without the number and the extension
  std::optional<std::uint64_t> number;
};

// The number is of the file's name: that of its folder numbers no pictures.
NumberedName numbered(const fs::path& path) {
  constexpr const char* kDigits = "0123456789";
  std::string name = path.stem().string();
  const std::size_t end = name.find_last_of(kDigits) + 1;
  if (end == 0) return {};
  const std::size_t begin = name.find_last_not_of(kDigits, end - 1) + 1;
  const auto number = parse_number<std::uint64_t>(name.substr(begin, end - begin));
  return {(path.parent_path() / name.erase(begin, end - begin)).string(), number};
}

// The lens of such a focal length for 35 mm film, whose diagonal is that of the picture (CIPA DCG-001), with
// its axis in the middle; none where no length is stated, or none that a lens can have.
std::optional<Intrinsics> lens_of(double focal_35mm_mm, int width_px, int height_px) {
  const double film_diagonal_mm = std::hypot(36, 24);
  const double focal_px = focal_35mm_mm / film_diagonal_mm * std::hypot(width_px, height_px);
  const Intrinsics lens{focal_px, focal_px, 0.5 * width_px, 0.5 * height_px};
  return objection_to(lens, width_px, height_px) ? std::nullopt : std::optional(lens);
}

// ", turned by 90 degrees as it states"; "" where nothing is.
std::string once_turned(Orientation orientation) {
  return orientation == Orientation::Upright ? "" : fmt::format(", {} as it states", describe(orientation));
}

// The files of a clip one after the other. A file that does not say when its frames are, as a still does not,
// goes on at the frame rate.
class FootageFiles : public FootageReader {
 public:
  FootageFiles(Storage& storage, std::vector<std::string> files, double framerate_hz)
      : storage_(storage),
        files_(std::move(files)),
        stills_hz_(framerate_hz > 0 ? framerate_hz : kUsualFramerate_hz) {}

  Result<void> open_first() {
    if (!TRY(read(ahead_)))
      return Error{ErrorCode::NotRecording, fmt::format("'{}' holds no pictures", files_.front())};
    has_ahead_ = true;
    const bool still = file_->facts().still;
    camera_.name = still ? file_->facts().model : fs::path(files_.front()).stem().string();
    camera_.width = ahead_.codes.cols(), camera_.height = ahead_.codes.rows();
    camera_.bits = file_->facts().bits, camera_.layout = file_->facts().layout;
    camera_.framerate_hz = file_->facts().framerate_hz > 0 ? file_->facts().framerate_hz : stills_hz_;
    camera_.linear = file_->facts().linear, white_ = file_->facts().white;
    camera_.white_balance = file_->facts().white_balance;
    camera_.intrinsics = lens_of(file_->facts().focal_35mm_mm, camera_.width, camera_.height);
    about_ = file_->facts().format;
    TRY(check_size());
    TRY(check_model());
    return {};
  }

  const CameraFacts& camera() const override { return camera_; }
  std::string about() const override { return about_; }
  const std::string& primaries() const override { return primaries_; }
  const std::vector<OrientedFile>& orientations() const override { return orientations_; }
  bool oblique() const override { return oblique_; }

  std::optional<ExifTime> taken() const override { return taken_; }
  ExifFactors factors() const override { return factors_; }
  const std::string& path() const override { return files_[next_file_ - 1]; }
  bool still() const override { return still_; }
  bool timed() const override { return timed_; }
  const std::vector<FootageLosses>& losses() const override { return losses_; }

  Result<bool> next(RawFrame& frame) override {
    if (std::exchange(has_ahead_, false)) {
      std::swap(frame.facts, ahead_.facts);
      std::swap(frame.codes, ahead_.codes);
      return true;
    }
    if (!TRY(read(frame))) return false;
    TRY(check_form(frame));
    if (still_ && file_->facts().model.empty()) camera_.name.clear();
    return check_model();
  }

 private:
  // Whether a recording can hold it; before all the others are read.
  Result<void> check_size() const {
    if (is_possible_side(camera_.width) && is_possible_side(camera_.height)) return {};
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' has {}x{} pixels, and a recording holds sides of {} to {}; crop or scale "
                             "the pictures first",
                             path(), camera_.width, camera_.height, kMinSidePx, kMaxSidePx)};
  }

  // Whether a later frame is like the first; both are upright.
  Result<void> check_form(const RawFrame& frame) const {
    const PictureFileFacts& facts = file_->facts();
    if (frame.codes.cols() == camera_.width && frame.codes.rows() == camera_.height &&
        facts.bits == camera_.bits && facts.layout == camera_.layout)
      return {};
    const Orientation first = orientations_.front().orientation;
    const char* const remedy =
        facts.still ? ", or have all state the same: exiftool -n -Orientation=1 FILES" : "";
    return Error{
        ErrorCode::SizeChanged,
        fmt::format(
            "'{}' has {}x{} pixels of {} bits, {}{}; the clip began with {}x{} of {} bits, {}{}; name "
            "the files of one {}{}",
            path(), frame.codes.cols(), frame.codes.rows(), facts.bits, name(facts.layout),
            once_turned(facts.orientation), camera_.width, camera_.height, camera_.bits, name(camera_.layout),
            once_turned(first), facts.orientation == first ? "kind and size" : "orientation",
            facts.orientation == first ? "" : remedy)};
  }

  // One clip has one response. Always true where it is no error.
  Result<bool> check_model() {
    const std::string& model = file_->facts().model;
    if (model.empty() || model == model_) return true;
    if (model_.empty()) return model_ = model, first_of_model_ = path(), true;
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' was taken by the camera '{}' and '{}' by '{}', whose responses differ; "
                             "import the pictures of each camera by themselves",
                             path(), model, first_of_model_, model_)};
  }

  // Cards that failed leave such files.
  Result<void> check_not_empty(const std::string& path) const {
    const FileFacts facts = TRY(storage_.look_at(path));
    if (facts.kind != FileKind::Regular || facts.size_bytes > 0) return {};
    return Error{ErrorCode::NotRecording, fmt::format("'{}' is empty; copy it again, or leave it out", path)};
  }

  Result<bool> read(RawFrame& frame) {
    for (;;) {
      if (!file_) {
        if (next_file_ == files_.size()) return false;
        const std::string& path = files_[next_file_++];
        TRY(check_not_empty(path));
        file_ = TRY(is_raw_still(path) ? open_raw_still(storage_, path, white_)
                                       : VideoFile::open(storage_, path));
        begin_ = last_ ? *last_ + period() : Instant{};
      }
      if (TRY(file_->next(frame))) break;
      end_file();
    }
    frame.facts.timestamp = TRY(time_of(frame.facts.timestamp.since_boot));
    frame.facts.sequence = frames_++;
    taken_ = file_->taken();
    factors_ = file_->factors();
    still_ = file_->facts().still;
    timed_ = file_->facts().timed;
    oblique_ |= file_->facts().oblique;
    note_orientation();
    if (primaries_.empty()) primaries_ = file_->facts().primaries;
    last_ = frame.facts.timestamp;
    return true;
  }

  void note_orientation() {
    const Orientation here = file_->facts().orientation;
    if (std::ranges::find(orientations_, here, &OrientedFile::orientation) == orientations_.end())
      orientations_.push_back({path(), here});
  }

  Result<Instant> time_of(Duration in_file) const {
    const auto possible = [](Duration time) { return time >= -kLatest && time <= kLatest; };
    if (possible(in_file) && possible(begin_.since_boot + in_file)) return begin_ + in_file;
    return Error{
        ErrorCode::Corrupt,
        fmt::format("frame {}, in '{}', would come {:.3g} s after the first one; import the files one by "
                    "one, or give them sound times first: ffmpeg -fflags +genpts",
                    frames_, path(), to_seconds(begin_.since_boot) + to_seconds(in_file))};
  }

  // The next file goes on after what this one should have held.
  void end_file() {
    const PictureLosses lost = file_->losses();
    if (lost.damaged + lost.missing > 0) losses_.push_back({path(), lost});
    if (!last_) return file_.reset();
    const double missing_s = std::min(lost.missing * to_seconds(period()), to_seconds(kLatest));
    last_->since_boot = std::min(kLatest, last_->since_boot + from_seconds(missing_s));
    file_.reset();
  }

  Duration period() const {
    const double hz = camera_.width > 0 ? camera_.framerate_hz : stills_hz_;
    return from_seconds(1 / hz);
  }

  Storage& storage_;
  const std::vector<std::string> files_;
  const double stills_hz_;
  CameraFacts camera_;
  int white_ = 0;  // of the first file, by which all are stretched
  std::string about_, primaries_;
  std::string model_, first_of_model_;  // of the camera, and the file that stated it; "": none yet
  std::size_t next_file_ = 0;
  std::unique_ptr<PictureFile> file_;
  std::uint64_t frames_ = 0;
  Instant begin_;
  std::optional<Instant> last_;
  std::optional<ExifTime> taken_;
  ExifFactors factors_;
  bool still_ = false, timed_ = false, oblique_ = false;
  std::vector<OrientedFile> orientations_;
  std::vector<FootageLosses> losses_;
  RawFrame ahead_;  // the first frame, which says what the clip is
  bool has_ahead_ = false;
};

}  // namespace

bool is_next_number(const std::string& file, const std::string& next) {
  const NumberedName a = numbered(file), b = numbered(next);
  return a.number && b.number && a.text == b.text && *a.number + 1 == *b.number;
}

bool is_earlier_number(const std::string& file, const std::string& next) {
  const NumberedName a = numbered(file), b = numbered(next);
  return a.number && b.number && a.text == b.text && *b.number < *a.number;
}

Result<std::unique_ptr<FootageReader>> open_footage(Storage& storage, std::vector<std::string> files,
                                                    double framerate_hz) {
  HDRCAM_CHECK(!files.empty());
  auto footage = std::make_unique<FootageFiles>(storage, std::move(files), framerate_hz);
  TRY(footage->open_first());
  return std::unique_ptr<FootageReader>(std::move(footage));
}

bool is_still(const std::string& path) { return is_raw_still(path) || has_one_of(path, kStills); }

bool is_footage(const std::string& path) { return is_still(path) || has_one_of(path, kVideos); }

Result<std::vector<std::string>> footage_in(const std::string& folder) {
  const FolderListing listing(folder);
  std::vector<std::string> files = files_of(listing, is_regular_file, is_footage);
  if (listing.failure()) return listing.cannot_read();
  if (!files.empty()) return files;
  return Error{ErrorCode::NotFound,
               fmt::format("there is no clip.json in '{}', no JPEG, PNG, TIFF or raw still and no video; {}",
                           folder, where_else(listing))};
}

std::vector<std::string> other_pictures_in(const std::string& folder) {
  return files_of(FolderListing(folder), is_regular_file, is_other_picture);
}

std::vector<std::string> broken_links_in(const std::string& folder) {
  return files_of(FolderListing(folder), is_broken_link,
                  [](const std::string& path) { return is_footage(path) || is_other_picture(path); });
}

}  // namespace hdrcam
