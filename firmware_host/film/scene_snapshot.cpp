#include "firmware_host/film/scene_snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/core/possible_pose.h"
#include "online/scene/hash_grid/field/window.h"
#include "online/scene/scene_fields.h"
#include "render/views/keyframe_file.h"

namespace hdrcam {

template <Either<PathPose> Pose>
void list_fields(auto& fields, Pose& pose) {
  fields(pose.time_s, pose.T_world_camera, pose.world);
}

// All but the codes.
template <Either<ExposedFrame> Frame>
void list_fields(auto& fields, Frame& frame) {
  fields(frame.facts, frame.index, frame.exposure, frame.reference_exposure, frame.interval_s,
         frame.blur_fraction);
}

template <Either<SceneHead> Head>
void list_fields(auto& fields, Head& head) {
  fields(head.program, head.camera, head.first, head.path, head.frames, head.input, head.has_field);
}

namespace {

constexpr SectionFormat kFormat{.what = "a snapshot of a scene",
                                .magic = {'\x89', 'H', 'D', 'R', 'S', 'C', 'N', '\n'},
                                .version = 2,
                                .mend = "copy it again, or save it again with --snapshot"};
constexpr std::string_view kHead = "scene", kResponse = "response", kInput = "input";
constexpr std::size_t kMostFrames = WindowOptions::kMostFrames;  // a run keeps those of the field's window
constexpr std::size_t kMostPath = 100000;

using Curves = std::array<Response::Curve, 3>;

bool positive(double value) { return value > 0 && value <= 1e12; }

bool is_possible(const Keyframe& key, const SceneHead& scene) {
  const HdrFrame& frame = key.frame;
  if (objection_to(frame.facts, nullptr) || objection_to(key.lens, scene.camera.width, scene.camera.height))
    return false;
  if (frame.lens && objection_to(*frame.lens, scene.camera.width, scene.camera.height)) return false;
  if (frame.neutral_gains && objection_to(*frame.neutral_gains)) return false;
  if (frame.pose && !is_possible_pose(frame.pose->T_world_camera)) return false;
  return std::isfinite(key.time_s) && is_possible_pose(key.T_world_camera) &&
         positive(static_cast<double>(key.depth_unit)) && positive(static_cast<double>(frame.exposure)) &&
         positive(frame.reference_exposure) && positive(static_cast<double>(frame.white));
}

bool is_possible(const SceneHead& scene) {
  const CameraFacts& camera = scene.camera;
  for (const int side : {camera.width, camera.height})
    if (!is_possible_side(side)) return false;
  FrameFacts begin;
  begin.timestamp = scene.first;
  if (objection_to(camera) || objection_to(begin, nullptr) || objection_to(scene.input.facts, nullptr))
    return false;
  if (scene.frames.empty() || scene.frames.size() > kMostFrames || scene.path.size() > kMostPath)
    return false;
  double before_s = -std::numeric_limits<double>::infinity();
  const auto later = [&](double time_s) {
    return std::abs(time_s) <= kLatest_s && time_s > std::exchange(before_s, time_s);
  };
  for (const PathPose& pose : scene.path)
    if (!later(pose.time_s) || !is_possible_pose(pose.T_world_camera)) return false;
  return std::ranges::all_of(
      scene.frames, [&](const Keyframe& key) { return later(key.time_s) && is_possible(key, scene); });
}

Result<void> read_head(SectionReader& file, SceneHead& head) {
  TRY(file.begin(kHead));
  TRY(file.read_fields(head));
  return is_possible(head) ? Result<void>() : file.wrong("it holds values that no scene has");
}

// Curves that are what Response makes of curves.
bool are_sound(const Curves& inverse, const Curves& uncertainty) {
  for (std::size_t c = 0; c < inverse.size(); ++c) {
    for (std::size_t z = 1; z < inverse[c].size(); ++z)
      if (!(inverse[c][z] > inverse[c][z - 1])) return false;
    if (!(inverse[c].front() >= 0) || !(std::abs(inverse[c].back() - 1) < 1e-4f)) return false;
    for (const float sigma : uncertainty[c])
      if (!(sigma >= 0) || !std::isfinite(sigma)) return false;
  }
  return true;
}

Result<Response> read_response(SectionReader& file) {
  std::array<Curves, 2> curves{};
  TRY(file.begin(kResponse));
  if (file.length() != sizeof curves) return file.wrong("it does not hold six curves");
  TRY(file.read(std::as_writable_bytes(std::span(curves))));
  TRY(file.end());
  if (!are_sound(curves[0], curves[1])) return file.wrong("its curves are no camera's");
  return Response::of_curves(curves[0], curves[1]);
}

Result<void> read_codes(SectionReader& file, int rows, int cols, Image<float>& codes) {
  TRY(file.begin(kInput));
  const std::uint64_t pixels = pixel_count(rows, cols);
  if (file.length() != 3 * sizeof(float) * pixels) return file.wrong("it is not as large as its picture");
  codes.reshape(3, rows, cols);
  TRY(file.read(std::as_writable_bytes(codes.samples())));
  TRY(file.end());
  const bool sound =
      std::ranges::all_of(codes.samples(), [](float code) { return std::abs(code) <= 2 * kMaxCode; });
  return sound ? Result<void>() : file.wrong("it holds a value that is no code");
}

}  // namespace

Result<bool> is_scene_snapshot(Storage& storage, const std::string& path) {
  return is_section_file(storage, path, kFormat);
}

Result<SceneSnapshot> load_scene(Storage& storage, const std::string& path, GpuDevice* gpu) {
  SectionReader file = TRY(SectionReader::open(storage, path, kFormat));
  SceneSnapshot scene;
  TRY(read_head(file, scene.head()));
  const int rows = scene.camera.height, cols = scene.camera.width;
  scene.response = TRY(read_response(file));
  for (Keyframe& key : scene.frames) {
    TRY(load_pictures(file, rows, cols, key));
    if (&key != &scene.frames.front() && key.to_previous.empty()) return file.wrong("it has no motion");
  }
  TRY(read_codes(file, rows, cols, scene.input.codes));
  if (scene.has_field) scene.field = TRY(load_field(file, gpu));
  TRY(file.end_of_file());
  return scene;
}

Result<SceneHead> scene_head(Storage& storage, const std::string& path) {
  SectionReader file = TRY(SectionReader::open(storage, path, kFormat));
  SceneHead head;
  TRY(read_head(file, head));
  return head;
}

Result<SceneHead> check_scene(Storage& storage, const std::string& path) {
  SectionReader file = TRY(SectionReader::open(storage, path, kFormat));
  SceneHead head;
  TRY(read_head(file, head));
  TRY(file.pass_to_end());
  return head;
}

const Keyframe* newest_posed(const SceneHead& scene) {
  const auto posed = std::find_if(scene.frames.rbegin(), scene.frames.rend(),
                                  [](const Keyframe& key) { return key.frame.pose.has_value(); });
  return posed == scene.frames.rend() ? nullptr : &*posed;
}

FilmedRecording filmed(const SceneHead& scene) {
  const Keyframe &newest = scene.frames.back(), *posed = newest_posed(scene);
  return {.first = scene.first,
          .begin_s = scene.frames.front().time_s - scene.first.seconds(),
          .duration_s = newest.time_s - scene.first.seconds(),
          .framerate_hz = scene.camera.framerate_hz,
          .width = scene.camera.width,
          .height = scene.camera.height,
          .has_poses = posed != nullptr && posed->frame.length_unit == LengthUnit::Metre,
          .stands_still = posed != nullptr && posed->frame.pose->source == PoseSource::Fixed,
          .has_exposure_times = std::ranges::all_of(
              scene.frames, [](const Keyframe& key) { return key.frame.facts.has_exposure_time(); }),
          .kind = scene.has_field ? FilmedKind::Snapshot : FilmedKind::SnapshotWithoutField};
}

Result<SceneWriter> SceneWriter::create(FileInMaking making, const SceneHead& head,
                                        const Response& response) {
  SceneWriter writer(TRY(SectionWriter::create(std::move(making), kFormat)));
  FieldsOut fields;
  fields(head);
  TRY(writer.file_.add(kHead, fields.bytes()));
  std::vector<Bytes> curves;
  for (int c = 0; c < 3; ++c) curves.push_back(std::as_bytes(std::span(response.inverse(c))));
  for (int c = 0; c < 3; ++c) curves.push_back(std::as_bytes(std::span(response.uncertainty(c))));
  TRY(writer.file_.add(kResponse, curves));
  return writer;
}

Result<void> SceneWriter::add(const Keyframe& frame) { return save_pictures(frame, file_); }

Result<void> SceneWriter::finish(const ExposedFrame& input, const SnapshotHold& field) {
  TRY(file_.add(kInput, std::as_bytes(input.codes.samples())));
  if (field) TRY(field->save(file_));
  return file_.finish();
}

}  // namespace hdrcam
