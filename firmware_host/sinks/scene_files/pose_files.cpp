#include "firmware_host/sinks/scene_files/pose_files.h"

#include <fmt/format.h>

#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "firmware_host/sinks/scene_files/transforms_json.h"
#include "firmware_host/terminal.h"
#include "render/tone_curve.h"

namespace hdrcam {
namespace {

constexpr std::size_t kMostPictures = 100'000;
constexpr std::size_t kFramesWithPoints = 32;
constexpr std::size_t kWorldsWithPoints = 3;
constexpr std::string_view kBlanks = " \t\n\v\f\r";

std::optional<FramePattern> pattern_of(const std::string& text, std::string_view extension) {
  auto parsed = FramePattern::parse("", text, extension);
  return parsed ? std::optional(std::move(parsed.value())) : std::nullopt;
}

// The pictures, as a sink of frames; what is written in the end is up to the subclass.
class PoseFile : public FrameSink {
 public:
  // pictures: as pictures_of() found them in the patterns
  PoseFile(Storage& storage, std::string_view flag, FramePattern pictures, const PicturePatterns& patterns)
      : storage_(storage),
        flag_(flag),
        pictures_(std::move(pictures)),
        depths_(pattern_of(patterns.depths, ".png")),
        earlier_(storage, patterns.pictures) {}

  Result<void> emit(const EmittedFrame& emitted) override {
    const HdrFrame& frame = emitted.hdr;
    if (!start_) start_ = frame.facts.timestamp;
    if (!frame.pose) return ++clip_.left_out, Result<void>{};
    if (!std::exchange(begun_, true)) TRY(begin(frame));
    if (frame.pose->lost || clip_.pictures.size() == kMostPictures) return ++clip_.left_out, Result<void>{};
    PosedPicture picture =
        posed_picture(pictures_.path(frame.facts.sequence), frame.facts, *start_, frame.pose->T_world_camera);
    if (depths_) picture.depth_path = depths_->path(frame.facts.sequence);
    picture.world = frame.pose->world;
    clip_.pictures.push_back(std::move(picture));
    ++worlds_[frame.pose->world].pictures;
    forget_smallest_world(frame.pose->world);
    take_points(frame);
    return {};
  }

  Result<void> conclude(const RunRecord&) override {
    if (clip_.pictures.empty()) return none_posed();
    for (const auto& [number, world] : worlds_)
      for (const std::vector<ColouredPoint>& points : world.points)
        clip_.points.insert(clip_.points.end(), points.begin(), points.end());
    // A camera's run sheds pictures of some frames; in their place there may be those of an earlier run.
    keep_pictures([&](const PosedPicture& picture) { return was_written(picture.path); });
    if (clip_.pictures.empty()) return {};  // that they failed, or were all shed, is told of the pictures
    leave_out_other_worlds();
    return write(storage_, clip_, pictures_.folder());
  }

 protected:
  // folder: of the pictures
  virtual Result<void> write(Storage& storage, const PosedClip& clip, const std::string& folder) = 0;

 private:
  // The first frame with a pose decides what the poses are.
  Result<void> begin(const HdrFrame& frame) {
    if (!frame.lens)
      return Error{
          ErrorCode::Invalid,
          fmt::format("{} needs pictures of one lens, and --stereo makes two a frame; leave out one of them",
                      flag_)};
    TRY(check_lens(frame.pose->source, frame.lens_is_assumed, "the recording"));
    clip_.width = frame.radiance.cols(), clip_.height = frame.radiance.rows();
    clip_.lens = *frame.lens;
    clip_.lens_is_assumed = frame.lens_is_assumed;
    clip_.source = frame.pose->source;
    return {};
  }

  // Without a picture there is no file: a run that failed before its first frame has told why.
  Result<void> none_posed() const {
    if (clip_.left_out == 0) return {};
    return Error{ErrorCode::Invalid,
                 fmt::format("{} needs poses, and no frame has one that is not lost; of a film give another "
                             "--time, or leave out --emit state and --set field=none",
                             flag_)};
  }

  void take_points(const HdrFrame& frame) {
    if (frame.points.empty()) return;
    const ToneCurve& curve = tone_.follow(frame.radiance);
    std::deque<std::vector<ColouredPoint>>& frames = worlds_[frame.pose->world].points;
    std::vector<ColouredPoint>& points = frames.emplace_back();
    for (const SurfacePoint& point : frame.points) {
      ColouredPoint coloured{point.p_world, {}, clip_.pictures.size() - 1, point.u_px, point.v_px};
      for (std::size_t c = 0; c < 3; ++c) coloured.rgb[c] = curve.code(point.radiance[c]);
      points.push_back(coloured);
    }
    if (frames.size() > kFramesWithPoints) frames.pop_front();
  }

  // A run may begin anew without end: only what the largest worlds saw is kept, beside the present one's.
  void forget_smallest_world(int present) {
    if (worlds_.size() <= kWorldsWithPoints) return;
    auto smallest = worlds_.end();
    for (auto world = worlds_.begin(); world != worlds_.end(); ++world)
      if (world->first != present &&
          (smallest == worlds_.end() || world->second.pictures < smallest->second.pictures))
        smallest = world;
    worlds_.erase(smallest);
  }

  bool was_written(const std::string& picture) const {
    return is_there(storage_, picture) && !earlier_.remains(picture);
  }

  // Leaves out the other pictures, and the points that they saw.
  template <class Kept>
  void keep_pictures(const Kept& kept) {
    std::vector<std::optional<std::size_t>> place(clip_.pictures.size());
    std::vector<PosedPicture> pictures;
    for (std::size_t i = 0; i < clip_.pictures.size(); ++i) {
      if (!kept(clip_.pictures[i])) {
        ++clip_.left_out;
        continue;
      }
      place[i] = pictures.size();
      pictures.push_back(std::move(clip_.pictures[i]));
    }
    clip_.pictures = std::move(pictures);
    std::erase_if(clip_.points, [&](const ColouredPoint& point) { return !place[point.picture]; });
    for (ColouredPoint& point : clip_.points) point.picture = *place[point.picture];
  }

  void leave_out_other_worlds() {
    std::map<int, std::size_t> pictures;
    for (const PosedPicture& picture : clip_.pictures) ++pictures[picture.world];
    if (pictures.size() < 2) return;
    auto largest = pictures.begin();
    for (auto world = pictures.begin(); world != pictures.end(); ++world)
      if (world->second >= largest->second) largest = world;
    const std::size_t all = clip_.pictures.size();
    keep_pictures([&](const PosedPicture& picture) { return picture.world == largest->first; });
    remark(
        "note: tracking began anew, and poses before and after do not belong together: {} has {} of {} "
        "pictures\n",
        flag_, clip_.pictures.size(), all);
  }

  struct World {
    std::size_t pictures = 0;
    std::deque<std::vector<ColouredPoint>> points;  // of its newest frames that have any
  };

  Storage& storage_;
  const std::string flag_;
  const FramePattern pictures_;
  const std::optional<FramePattern> depths_;
  const EarlierFrames earlier_;
  std::optional<Instant> start_;
  bool begun_ = false;
  PosedClip clip_;
  std::map<int, World> worlds_;
  ToneAdaptation tone_;
};

class TransformsFile final : public PoseFile {
 public:
  TransformsFile(Storage& storage, std::string path, FramePattern pictures, const PicturePatterns& patterns)
      : PoseFile(storage, "--transforms", std::move(pictures), patterns), path_(std::move(path)) {}

 private:
  Result<void> write(Storage& storage, const PosedClip& clip, const std::string&) override {
    const std::string text = to_transforms_json(clip, folder_of(path_));
    return write_whole(storage, path_, std::as_bytes(std::span(text)));
  }

  const std::string path_;
};

class ColmapModel final : public PoseFile {
 public:
  ColmapModel(Storage& storage, std::string model, FramePattern pictures, const PicturePatterns& patterns)
      : PoseFile(storage, "--colmap", std::move(pictures), patterns), model_(std::move(model)) {}

 private:
  Result<void> write(Storage& storage, const PosedClip& clip, const std::string& folder) override {
    return write_colmap(storage, model_, clip, folder);
  }

  const std::string model_;
};

}  // namespace

Result<FramePattern> pictures_of(std::string_view flag, const PicturePatterns& patterns) {
  for (const char* extension : {".exr", ".png"})
    if (auto pattern = pattern_of(patterns.pictures, extension)) return std::move(*pattern);
  return Error{ErrorCode::Invalid,
               fmt::format("{} names the pictures of the run, but it leaves none; give --output out/%06d.exr "
                           "or --preview out/%06d.png too",
                           flag)};
}

Result<FramePattern> pictures_of_colmap(const PicturePatterns& patterns) {
  FramePattern pictures = TRY(pictures_of("--colmap", patterns));
  for (const std::string_view part : {pictures.name_before(), pictures.name_after()})
    if (part.find_first_of(kBlanks) != std::string_view::npos)
      return Error{
          ErrorCode::Invalid,
          fmt::format("--colmap cannot name the pictures '{}': COLMAP splits the lines of images.txt at "
                      "blanks; name them without, such as out/%06d.png",
                      patterns.pictures)};
  return pictures;
}

Result<std::unique_ptr<FrameSink>> create_transforms(Storage& storage, const std::string& path,
                                                     const PicturePatterns& patterns) {
  auto pictures = TRY(pictures_of("--transforms", patterns));
  TRY(make_folder_of(storage, path));
  return std::unique_ptr<FrameSink>(
      std::make_unique<TransformsFile>(storage, path, std::move(pictures), patterns));
}

Result<std::unique_ptr<FrameSink>> create_colmap(Storage& storage, const std::string& model,
                                                 const PicturePatterns& patterns) {
  auto pictures = TRY(pictures_of_colmap(patterns));
  TRY(storage.make_directories(model));
  return std::unique_ptr<FrameSink>(
      std::make_unique<ColmapModel>(storage, model, std::move(pictures), patterns));
}

}  // namespace hdrcam
