#include "render/scores/ground_truth.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "hal/core/json_text.h"
#include "render/exr.h"
#include "render/scores/linear_pictures.h"

namespace hdrcam {
namespace {

Result<nlohmann::json> read_json(Storage& storage, const std::string& path) {
  const std::string text = TRY(read_whole(storage, path));
  auto json = parsed_json<nlohmann::json>(text);
  if (json.is_discarded())
    return Error{ErrorCode::Corrupt, fmt::format("'{}' is not JSON; make the clip again", path)};
  if (const auto key = repeated_key<nlohmann::json>(text))
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' names '{}' twice in one object; name it once", path, *key)};
  return json;
}

// Eight-bit grey samples [1, rows, cols] of a PNG. Its size is checked first: a few damaged bytes of a header
// must not cost gigabytes.
Result<Image<std::uint8_t>> read_grey_png(Storage& storage, const std::string& path, int rows, int cols) {
  const std::string bytes = TRY(read_whole(storage, path));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto damaged = [&] {
    Error error{ErrorCode::Corrupt, fmt::format("'{}' is not a readable PNG picture: {}", path, png.message)};
    png_image_free(&png);
    return error;
  };
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) return damaged();
  if (const auto sized =
          check_size(static_cast<int>(png.height), static_cast<int>(png.width), path, rows, cols);
      !sized) {
    png_image_free(&png);
    return sized.error();
  }
  png.format = PNG_FORMAT_GRAY;
  Image<std::uint8_t> image(1, rows, cols);
  if (png_image_finish_read(&png, nullptr, image.plane(0), image.cols(), nullptr) == 0) return damaged();
  return image;
}

// An optional picture: an empty value where there is no file.
template <class T>
Result<T> or_empty(Result<T> read) {
  if (!read && read.error().code == ErrorCode::NotFound) return T{};
  return read;
}

// Seconds x gains, which may be left out. which: "frame 3 of 'walk/clip.json'".
Result<double> exposure_of(const nlohmann::json& frame, const std::string& which) {
  (void)frame.at("exposure_s");
  double exposure = 1;
  for (const char* factor : {"exposure_s", "gain", "digital_gain"}) {
    const double value = frame.value(factor, 1.0);
    if (!(value > 0) || !std::isfinite(value))
      return Error{ErrorCode::BadExposure,
                   fmt::format("{} states {} {}; it must be above 0", which, factor, value)};
    exposure *= value;
  }
  return exposure;
}

// Of each frame of the clip.
std::vector<std::optional<PosePair>> novel_cameras_of(const nlohmann::json& truth, std::size_t frames) {
  std::vector<std::optional<PosePair>> cameras(frames);
  const auto poses = truth.value("frames", nlohmann::json::array());
  for (std::size_t i = 0; i < std::min(poses.size(), cameras.size()); ++i)
    if (poses[i].contains("c2w") && poses[i].contains("novel_c2w"))
      cameras[i] = PosePair{poses[i]["c2w"].get<PoseMatrix>(), poses[i]["novel_c2w"].get<PoseMatrix>()};
  return cameras;
}

}  // namespace

Result<GroundTruth> GroundTruth::open(Storage& storage, const std::string& clip_folder) {
  GroundTruth truth(storage, clip_folder);
  TRY(truth.read_facts());
  return truth;
}

Result<void> GroundTruth::read_facts() {
  const std::string clip_path = folder_ + "/clip.json", truth_path = folder_ + "/gt/gt.json";
  const auto clip = read_json(*storage_, clip_path);
  if (!clip) return clip.error();
  const auto truth = read_json(*storage_, truth_path);
  if (!truth && truth.error().code == ErrorCode::NotFound)
    return Error{ErrorCode::NotFound,
                 fmt::format("'{}' has no ground truth ('{}' does not exist); name a clip with a gt folder",
                             folder_, truth_path)};
  if (!truth) return truth.error();
  try {
    const nlohmann::json &width = clip.value().at("width"), &height = clip.value().at("height");
    const auto cols = whole_number<int>(width), rows = whole_number<int>(height);
    if (!cols || !rows)
      return Error{ErrorCode::Corrupt, fmt::format("'{}' states {}x{} pixels; whole numbers are needed",
                                                   clip_path, json_text(width), json_text(height))};
    cols_ = *cols, rows_ = *rows;
    for (const auto& frame : clip.value().at("frames")) {
      const std::string which = fmt::format("frame {} of '{}'", frames(), clip_path);
      const auto stated = frame.find("sequence");
      const auto number = stated == frame.end() ? std::optional(static_cast<std::uint64_t>(frames()))
                                                : whole_number<std::uint64_t>(*stated);
      if (!number)
        return Error{ErrorCode::Corrupt,
                     fmt::format("{} states sequence {}; it must be a whole number, 0 or above", which,
                                 json_text(*stated))};
      numbers_.push_back(*number);
      exposures_.push_back(TRY(exposure_of(frame, which)));
      const auto time = frame.find("time_s");
      times_s_.push_back(time != frame.end() && time->is_number() ? time->get<double>()
                                                                  : std::numeric_limits<double>::quiet_NaN());
    }
    novel_cameras_ = novel_cameras_of(truth.value(), numbers_.size());
    shortest_saturation_ = truth.value().at("r_sat_shortest").get<double>();
    for (const int id : truth.value().value("moving_ids", std::vector<int>{}))
      if (id >= 0 && id < 256) moving_ids_[static_cast<std::size_t>(id)] = anything_moves_ = true;
  } catch (const nlohmann::json::exception& e) {
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' does not describe a clip with ground truth: {}", folder_, json_reason(e))};
  }
  if (cols_ <= 0 || rows_ <= 0 || !(shortest_saturation_ > 0))
    return Error{ErrorCode::Corrupt,
                 fmt::format("'{}' states {}x{} pixels that saturate at radiance {}; all must be above 0",
                             folder_, cols_, rows_, shortest_saturation_)};
  return {};
}

double GroundTruth::interval_s() const {
  const auto steps = static_cast<double>(numbers_.back()) - static_cast<double>(numbers_.front());
  return std::abs(time_s(frames() - 1) / steps);
}

std::string GroundTruth::path(const char* kind, int frame, const char* extension) const {
  return fmt::format("{}/gt/{}/{:04d}.{}", folder_, kind, frame, extension);
}

Result<Image<float>> GroundTruth::radiance(int frame) const {
  return read_true_rgb(*storage_, path("hdr", frame, "exr"), rows_, cols_);
}

Result<Image<float>> GroundTruth::novel_radiance(int frame) const {
  return or_empty(read_true_rgb(*storage_, path("novel", frame, "exr"), rows_, cols_));
}

Result<MotionTruth> GroundTruth::motion(int frame) const {
  const auto picture = TRY(or_empty(read_true_rgb(*storage_, path("flow", frame, "exr"), rows_, cols_)));
  MotionTruth motion;
  if (picture.empty()) return motion;
  motion.flow.reshape(2, rows_, cols_);
  motion.comparable.reshape(1, rows_, cols_);
  for (int y = 0; y < rows_; ++y) {
    for (int x = 0; x < cols_; ++x) {
      const float dx = motion.flow.at(0, y, x) = picture.at(0, y, x);
      const float dy = motion.flow.at(1, y, x) = picture.at(1, y, x);
      const float to_x = static_cast<float>(x) + dx, to_y = static_cast<float>(y) + dy;
      const bool inside = to_x >= 0 && to_y >= 0 && to_x <= static_cast<float>(cols_ - 1) &&
                          to_y <= static_cast<float>(rows_ - 1);
      motion.comparable.at(0, y, x) = inside && picture.at(2, y, x) < 0.5f;
    }
  }
  return motion;
}

Result<Image<float>> GroundTruth::depth(int frame) const {
  const std::string name = path("depth", frame, "exr");
  auto read = TRY(or_empty(read_exr(*storage_, name)));
  if (read.samples.empty()) return Image<float>{};
  Image<float> depth = plane_of(read, 0);
  TRY(check_size(depth, name, rows_, cols_));
  return depth;
}

Result<Image<std::uint8_t>> GroundTruth::moving_mask(int frame) const {
  if (!anything_moves_) return Image<std::uint8_t>{};
  Image<std::uint8_t> mask = TRY(or_empty(read_grey_png(*storage_, path("id", frame, "png"), rows_, cols_)));
  for (std::uint8_t& id : mask.samples()) id = moving_ids_[id];
  return mask;
}

}  // namespace hdrcam
