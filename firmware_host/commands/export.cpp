// hdrcam export x.mkv -o FOLDER: writes a recording as images and a clip.json, bit by bit the same; with the
// poses that it states, in the files of reconstruction tools too.
#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/no_snapshot.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/cut_recording.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "firmware_host/sinks/scene_files/transforms_json.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "hal/footage/footage.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

struct ExportOptions {
  std::string recording, folder;
  bool strict = false, transforms = false, colmap = false;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;

  Damage damage() const { return strict ? Damage::Ends : Damage::IsSkipped; }
  // Whether an error of the reader is no more than its end: the whole frames before a cut count.
  bool is_end(const Error& error) const { return error.code == ErrorCode::Truncated && !strict; }
  bool with_poses() const { return transforms || colmap; }
  std::string transforms_path() const { return transforms ? folder + "/transforms.json" : ""; }
  std::string model() const { return folder + "/colmap"; }
  std::string pictures() const { return fmt::format("{}/{}/%04d.png", folder, ImageSequence::kPictures); }
};

Error stopped_after(int frames) {
  if (frames == 0) return {ErrorCode::Interrupted, "stopped before the first frame"};
  return {ErrorCode::Interrupted,
          fmt::format("stopped after {}; their pictures are complete, but the folder has no clip.json",
                      counted(frames, "frame"))};
}

// Whether the recording states poses, and the lens that they need. A search in vain reads all of it.
Result<void> check_poses(const ExportOptions& options, Surroundings& around) {
  const auto reader = TRY(open_recording(around.storage, options.recording, options.damage()));
  for (;;) {
    if (around.stop) return stopped_after(0);
    auto facts = reader->next_facts();
    if (!facts && !options.is_end(facts.error())) return facts.error();
    if (!facts || !facts.value())
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}' states no poses; 'hdrcam replay {} --preview out/%06d.png --transforms "
                               "out/transforms.json' tracks the camera",
                               options.recording, shell_word(options.recording))};
    if ((**facts).T_world_camera) break;
  }
  return check_lens(PoseSource::Given, !reader->camera().intrinsics, fmt::format("'{}'", options.recording));
}

Result<void> check_files(Storage& storage, const ExportOptions& options) {
  std::vector<NamedOutput> outputs{
      {"--output", options.folder + "/" + ImageSequence::kFile, OutputKind::Document},
      {"--output", options.pictures(), OutputKind::Frames},
      {"--transforms", options.transforms_path(), OutputKind::Poses}};
  for (const std::string_view file : kColmapFiles)
    outputs.push_back(
        {"--colmap", options.colmap ? fmt::format("{}/{}", options.model(), file) : "", OutputKind::Poses});
  return options.kept.check(storage, {{"the file that is read", options.recording}}, outputs);
}

PosedClip posed_clip_of(const CameraFacts& camera) {
  PosedClip clip;
  clip.width = camera.width, clip.height = camera.height;
  clip.lens = camera.intrinsics.value_or(Intrinsics{});
  return clip;
}

// path: of the picture
void add_frame(const FrameFacts& facts, std::string path, Instant start, PosedClip& clip) {
  if (!facts.T_world_camera)
    ++clip.left_out;
  else
    clip.pictures.push_back(
        posed_picture(std::move(path), facts, start, transform_of(*facts.T_world_camera)));
}

Result<void> write_poses(Storage& storage, const ExportOptions& options, const PosedClip& clip) {
  if (options.transforms) {
    const std::string text = to_transforms_json(clip, options.folder);
    TRY(write_whole(storage, options.transforms_path(), std::as_bytes(std::span(text))));
  }
  if (options.colmap) TRY(write_colmap(storage, options.model(), clip, options.folder));
  if (clip.left_out > 0)
    remark("note: {} without a pose {} in the clip.json only\n", counted(clip.left_out, "frame"),
           clip.left_out == 1 ? "is" : "are");
  return {};
}

// What was written of a recording, and why nothing comes after it.
struct ExportedFrames {
  int count = 0;
  Result<void> ended;
  PosedClip posed;  // empty where no poses are asked for
};

Result<ExportedFrames> copy_frames(const ExportOptions& options, RecordingReader& from,
                                   ImageSequenceWriter& to, const std::atomic<bool>& stop) {
  ExportedFrames written;
  written.posed = posed_clip_of(from.camera());
  std::optional<Instant> start;
  for (;; ++written.count) {
    if (stop) return stopped_after(written.count);
    auto frame = from.next();
    if (!frame && !options.is_end(frame.error())) return frame.error();
    if (!frame) written.ended = frame.error();
    if (!frame || !frame.value()) return written;
    const FrameFacts& facts = (**frame).facts;
    if (!start) start = facts.timestamp;
    TRY(to.append(**frame));
    if (options.with_poses()) add_frame(facts, to.last_path(), *start, written.posed);
  }
}

// What is odd about the recording, about the clip, and about the folder.
void tell_of_clip(const RecordingReader& reader, int frames, const EarlierFrames& earlier) {
  for (const std::string& warning : warnings_of(reader)) remark("warning: {}\n", warning);
  if (frames < static_cast<int>(kFewestClipFrames))
    remark("warning: a clip has at least {} frames; 'hdrcam import' does not take this one\n",
           kFewestClipFrames);
  if (const std::string warning = earlier.warning(); !warning.empty()) remark("warning: {}\n", warning);
}

// Not of a file, nor of pictures, which export names itself.
Result<void> check_folder_name(Storage& storage, const ExportOptions& options) {
  const FileKind there = TRY(storage.look_at(options.folder)).kind;
  if (there == FileKind::Regular)
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' is a file; --output names the folder to write, such as frames", options.folder)};
  if (!FramePattern::parse("--output", options.pictures(), ".png"))
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' numbers pictures, which export does itself; --output names their folder, "
                             "such as frames",
                             options.folder)};
  if (there == FileKind::Missing && is_footage(options.folder))
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is the name of a picture or a video; --output names the folder to write, "
                             "such as frames",
                             options.folder)};
  return {};
}

// A truncated or damaged recording gives its whole frames; for a truncated one the end is Truncated.
Result<void> export_recording(const ExportOptions& options, const Settings& settings, Surroundings& around) {
  TRY(check_folder_name(around.storage, options));
  TRY(check_no_snapshot(around.storage, options.recording));
  if (options.with_poses()) TRY(check_poses(options, around));
  auto reader = TRY(open_recording(around.storage, options.recording, options.damage()));
  TRY(admit_copy(settings, reader->camera(), {CopyKind::Export}));
  TRY(check_files(around.storage, options));
  const EarlierFrames earlier(around.storage, options.pictures());
  auto clip =
      TRY(ImageSequenceWriter::create(around.storage, options.folder, reader->camera(), Creation::Replace));
  const ExportedFrames written = TRY(copy_frames(options, *reader, clip, around.stop));
  if (written.count == 0) {
    TRY(written.ended);
    return no_whole_frame(options.recording);
  }
  TRY(clip.finish());
  if (options.with_poses()) TRY(write_poses(around.storage, options, written.posed));
  tell_of_clip(*reader, written.count, earlier);
  say("{}: {}\n", options.folder, counted(written.count, "frame"));
  if (written.ended) return {};
  return read_to_cut(written.ended.error(), options.recording);
}

}  // namespace

void add_export(CommandLine program, Verb& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CommandLine verb = program.add_verb("export", "turn a recording into a folder of images with a clip.json");
  verb.add_option("recording", options->recording, "the recording (.mkv)").required().check(names_input);
  verb.add_option("-o,--output", options->folder, "the folder to write")
      .required()
      .transform(named_at_start)
      .check(names_folder);
  verb.add_switch("--transforms", options->transforms,
                  "the recording's poses as transforms.json in that folder, for nerfstudio and instant-ngp");
  verb.add_switch("--colmap", options->colmap,
                  "the recording's poses as a COLMAP text model in colmap/ of that folder, without points");
  verb.add_switch("--strict", options->strict, "fail where the recording is cut or damaged");
  options->kept.add_to(verb);
  options->settings = std::make_unique<SettingsFlags>(verb, std::vector<std::string>{"machine.memory_mib"});
  verb.on_chosen([options, &chosen] { chosen = with_settings(options, export_recording); });
}

}  // namespace hdrcam
