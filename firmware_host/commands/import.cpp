// hdrcam import FOOTAGE -o x.mkv: videos, pictures, or a folder of images with its clip.json become a
// recording.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "capture/recorded_labels.h"
#include "capture/recording_stage.h"
#include "capture/white_level.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/no_snapshot.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/footage/described_plan.h"
#include "firmware_host/footage/footage_plan.h"
#include "firmware_host/footage/low_codes.h"
#include "firmware_host/printable.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "hal/core/parse_number.h"
#include "hal/core/sound_facts.h"
#include "hal/footage/orientation.h"
#include "hal/footage/raw_still.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

struct ImportOptions {
  FootageRequest footage;
  std::string output;
  bool list = false;
  bool strict = false, allow_outside = false;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

// What the codes themselves show to be wrong or unusual with them.
struct CodeChecks {
  LowCodes low;
  WhiteSearch white;

  explicit CodeChecks(const CameraFacts& camera) : low(camera), white(camera) {}
  void observe(const RawFrame& frame) { low.observe(frame.codes), white.observe(frame); }
  // Sentences without a full stop, or "".
  std::string warning() const { return low.warning(); }
  std::string note() const {
    const WhiteLevel level = white.found();
    if (level.is_largest_code()) return "";
    return fmt::format(
        "the pictures clip at {:.0f} of 255 in red, {:.0f} in green and {:.0f} in blue; a run takes that for "
        "white if its first frames show it (docs/import.md, White level)",
        level[0], level[1], level[2]);
  }
};

// All frames, with the verdicts of the pictures on their exposures.
template <class Take>
Result<void> each_frame(Surroundings& around, RecordingStage& clip, CodeChecks& codes, const Take& take) {
  CapturedFrame frame;
  while (TRY(clip.next(frame))) {
    if (around.stop)
      return Error{ErrorCode::Interrupted, fmt::format("stopped at frame {} of {}; nothing was written",
                                                       clip.counters().captured - 1, *clip.frame_count())};
    codes.observe(frame.raw);
    TRY(take(frame.raw));
  }
  return {};
}

// Returns the number of frames.
Result<std::uint64_t> copy_frames(Surroundings& around, RecordingStage& clip, CodeChecks& codes,
                                  const std::string& path, RecordingCodec codec) {
  auto writer = TRY(create_recording(around.storage, path, clip.camera(), Creation::New, codec));
  TRY(each_frame(around, clip, codes, [&](const RawFrame& frame) { return writer->append(frame); }));
  TRY(writer->finish());
  return clip.counters().captured;
}

Result<bool> is_folder(Storage& storage, const std::string& path) {
  return TRY(storage.look_at(path)).kind == FileKind::Folder;
}

// A clip that says its exposures itself: its clip.json, or the folder that holds one.
Result<bool> is_clip(Storage& storage, const std::vector<std::string>& named) {
  if (named.size() != 1) return false;
  const std::filesystem::path path(named.front());
  if (path.extension() == ".json") return true;
  if (!TRY(is_folder(storage, path.string()))) return false;
  return TRY(storage.look_at((path / ImageSequence::kFile).string())).kind != FileKind::Missing;
}

// The files that must not be overwritten: the clip.json and every image.
std::vector<NamedInput> files_of(const ImageSequence& clip) {
  std::vector<NamedInput> files{{"the clip that is read", clip.path()}};
  for (int i = 0; i < clip.frame_count(); ++i) files.push_back({"a frame that is read", clip.path_of(i)});
  return files;
}

std::vector<NamedInput> files_of(const FootageRequest& footage) {
  std::vector<NamedInput> files;
  for (const std::string& file : footage.files) files.push_back({"the footage that is read", file});
  return files;
}

Contradiction contradiction_of(const ImportOptions& options) {
  return options.strict ? Contradiction::Fails : Contradiction::Warns;
}

// suspicion: what exposures that pictures contradict may come from; "": nothing is known.
void show_warnings(const RecordingStage& clip, const CodeChecks& codes, const std::string& suspicion) {
  for (const std::string& warning : clip.warnings()) remark("warning: {}\n", warning);
  const CaptureCounters frames = clip.counters();
  if (frames.contradicted + frames.relabelled > 0 && !suspicion.empty()) remark("note: {}\n", suspicion);
  if (const std::string warning = codes.warning(); !warning.empty()) remark("warning: {}\n", warning);
  if (const std::string note = codes.note(); !note.empty()) remark("note: {}\n", note);
}

// An incomplete file never has the name of the output, and an older output is replaced only when the new one
// is complete.
Result<void> write_recording(Surroundings& around, const ImportOptions& options, const Settings& settings,
                             std::unique_ptr<RecordingReader> reader, const std::string& suspicion) {
  RecordingStage clip(std::move(reader), contradiction_of(options));
  CodeChecks codes(clip.camera());
  FileInMaking making = TRY(FileInMaking::beside(around.storage, options.output));
  const std::uint64_t frames =
      TRY(making.as_asked(copy_frames(around, clip, codes, making.path(), settings.record.codec)));
  TRY(making.commit());
  const CameraFacts& camera = clip.camera();
  show_warnings(clip, codes, suspicion);
  say("{}\n", describe_recording(options.output, camera, frames));
  return {};
}

// What writing it would say and refuse, without a recording. Returns the facts of the frames.
Result<std::vector<FrameFacts>> judged_facts(Surroundings& around, const ImportOptions& options,
                                             std::unique_ptr<RecordingReader> reader,
                                             const std::string& suspicion) {
  RecordingStage clip(std::move(reader), contradiction_of(options));
  CodeChecks codes(clip.camera());
  std::vector<FrameFacts> facts;
  TRY(each_frame(around, clip, codes, [&](const RawFrame& frame) {
    facts.push_back(frame.facts);
    return Result<void>();
  }));
  show_warnings(clip, codes, suspicion);
  return facts;
}

// The images of a clip.json are read as they are stored, because its size, lens and poses are of those. The
// first one tells of the others.
void tell_orientation(Storage& storage, const std::string& first_image) {
  const auto file = read_whole(storage, first_image);
  if (!file) return;  // it changed since it was read
  const std::string& bytes = file.value();
  const Orientation stated =
      orientation_in_png({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  if (stated != Orientation::Upright)
    remark(
        "warning: '{}' states that it is to be shown {}, which is not applied; the images of a clip.json are "
        "taken as they are stored, as are its size, lens and poses\n",
        first_image, describe(stated));
}

Result<void> list_clip(Surroundings& around, const ImportOptions& options, ImageSequence clip) {
  CameraFacts camera = clip.camera();
  camera.name = printable(camera.name.empty() ? options.footage.files.front() : camera.name);
  auto facts = TRY(judged_facts(around, options, reader_of(std::move(clip)), ""));
  say("{}", described(plan_of_clip(std::move(camera), std::move(facts))));
  return {};
}

// Of so many frames, those that are judged together.
int most_waiting(std::size_t frames) {
  return static_cast<int>(std::min<std::size_t>(RecordedLabels::kBeginning, frames));
}

// Where the times of a clip.json are of another unit than its rate, milliseconds above all; "" where they may
// be of one. Slow stills may be so, too.
std::string unlike_rate(const ImageSequence& clip) {
  constexpr double kMost = 10;  // times
  const FrameFacts &first = clip.facts(0), &last = clip.facts(clip.frame_count() - 1);
  const double apart_s =
      to_seconds(last.timestamp - first.timestamp) / static_cast<double>(last.sequence - first.sequence);
  const double frame_s = 1 / clip.camera().framerate_hz;
  if (apart_s < kMost * frame_s && frame_s < kMost * apart_s) return "";
  return fmt::format("the frames are {:.3g} s apart by 'time_s' and {:.3g} s by 'fps'; both are of seconds",
                     apart_s, frame_s);
}

Result<void> import_clip(Surroundings& around, const ImportOptions& options, const Settings& settings) {
  const std::string& path = options.footage.files.front();
  auto clip = TRY(ImageSequence::open(around.storage, path,
                                      options.allow_outside ? ClipReach::Anywhere : ClipReach::BelowFolder));
  const std::string first_image = clip.path_of(0), times = unlike_rate(clip);
  if (!times.empty()) remark("note: {}\n", times);
  if (options.list) {
    TRY(list_clip(around, options, std::move(clip)));
    tell_orientation(around.storage, first_image);
    return {};
  }
  TRY(options.kept.check(around.storage, files_of(clip),
                         {{"--output", options.output, OutputKind::Recording}}));
  TRY(admit_copy(
      settings, clip.camera(),
      {CopyKind::Stills, most_waiting(static_cast<std::size_t>(clip.frame_count())), settings.record.codec}));
  TRY(write_recording(around, options, settings, reader_of(std::move(clip)), ""));
  tell_orientation(around.storage, first_image);
  return {};
}

// What a file that may be footage is as a recording: of a video or a picture none.
struct AsRecording {
  bool whole = false;                 // at least its first frame
  std::optional<Error> damaged = {};  // why none can be read
};
AsRecording as_recording(Storage& storage, const std::string& file) {
  constexpr std::uint64_t kLeastBytes = 4;  // that tell a Matroska file
  if (is_still(file)) return {};
  const auto opened = open_recording(storage, file);
  if (opened) return {.whole = true};
  const auto facts = storage.look_at(file);
  const Error& error = opened.error();
  if (!facts || facts.value().size_bytes < kLeastBytes) return {};
  if (error.code != ErrorCode::Truncated && error.code != ErrorCode::Corrupt) return {};
  return {.damaged = error};
}

// A frame of a bracket may be among them.
void tell_left_out(const std::vector<std::string>& files, std::string_view why) {
  if (files.empty()) return;
  const std::string more =
      files.size() > 1 ? fmt::format(" and {} more are", files.size() - 1) : std::string(" is");
  remark("note: '{}'{} left out: {}\n", files.front(), more, why);
}

// Pictures and videos, as phones leave them in one folder, or each still raw and developed, as many cameras
// do.
Result<void> check_one_kind(const std::vector<std::string>& files) {
  const auto is_developed = [](const std::string& file) { return is_still(file) && !is_raw_still(file); };
  const auto still = std::ranges::find_if(files, is_still), video = std::ranges::find_if_not(files, is_still);
  if (still != files.end() && video != files.end())
    return Error{ErrorCode::Invalid, fmt::format("'{}' and '{}' are a picture and a video, which do not make "
                                                 "one clip; name the files of one kind",
                                                 *still, *video)};
  const auto raw = std::ranges::find_if(files, is_raw_still);
  const auto developed = std::ranges::find_if(files, is_developed);
  if (raw == files.end() || developed == files.end()) return {};
  const std::filesystem::path one(*raw);
  return Error{
      ErrorCode::Invalid,
      fmt::format("'{}' and '{}' are a raw still and a developed one, which do not make one clip; name the "
                  "files of one kind, such as {}",
                  *raw, *developed, (one.parent_path() / ("*" + one.extension().string())).string())};
}

// What makes one clip of a folder: its stills, or its videos but not the recordings that were made of them.
Result<std::vector<std::string>> clip_in(Storage& storage, const std::string& folder) {
  tell_left_out(broken_links_in(folder), "a link whose file is not there");
  std::vector<std::string> files = TRY(footage_in(folder));
  std::erase_if(files, [&](const std::string& file) {
    const AsRecording recording = as_recording(storage, file);
    if (recording.whole) remark("note: '{}' is a recording already and is left out\n", file);
    if (recording.damaged)
      remark("warning: {}; this damaged recording is left out\n", recording.damaged->message);
    return recording.whole || recording.damaged;
  });
  if (files.empty())
    return Error{ErrorCode::NotFound,
                 fmt::format("'{}' holds recordings only, and no footage; replay them as they are", folder)};
  TRY(check_one_kind(files));
  if (is_still(files.front()))
    tell_left_out(other_pictures_in(folder),
                  "of a folder, JPEG, PNG, TIFF and raw stills are read; name others, or convert them");
  return files;
}

// Not a folder or a clip, nor a pattern of numbered files, as encode and other programs take it.
Result<void> check_named_one_by_one(Storage& storage, const std::string& file) {
  const FileKind kind = TRY(storage.look_at(file)).kind;
  if (kind == FileKind::Folder)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is a folder among other footage; import a folder by itself, or name its "
                             "files",
                             file)};
  if (kind == FileKind::Regular && std::filesystem::path(file).extension() == ".json")
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is a clip.json among other footage; import each clip by itself", file)};
  if (kind != FileKind::Missing || file.find('%') == std::string::npos) return {};
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return Error{ErrorCode::NotFound,
               fmt::format("'{}' does not exist; name the files one by one, or their folder, '{}'", file,
                           folder.empty() ? "." : folder)};
}

// With the files in the one folder that is named, or the files that are.
Result<FootageRequest> with_files(Storage& storage, FootageRequest request) {
  if (request.files.size() == 1 && TRY(is_folder(storage, request.files.front()))) {
    request.files = TRY(clip_in(storage, request.files.front()));
    request.order = FootageOrder::Numbers;
    return request;
  }
  for (const std::string& file : request.files) {
    TRY(check_named_one_by_one(storage, file));
    TRY(check_no_snapshot(storage, file));
    const AsRecording recording = as_recording(storage, file);
    if (recording.damaged)
      return Error{recording.damaged->code,
                   fmt::format("{}; a damaged recording is not footage", recording.damaged->message)};
    if (recording.whole)
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}' is a recording already; use it as it is: hdrcam replay {}", file,
                               shell_word(file))};
  }
  return request;
}

void warn_of_phase(const FootagePlan& plan) {
  if (plan.walk.ambiguous)
    remark(
        "warning: the pictures show as well that the cycle begins with another exposure; all exposures may "
        "be wrong by one factor, so import more frames\n");
}

// In which order the files come, where it is not the one that their names suggest.
void tell_order(const FootagePlan& plan) {
  if (plan.goes_round)
    return remark(
        "note: '{}' is the first frame, as EXIF says: the numbers of the files begin anew on the way\n",
        plan.files.front());
  const auto turn = std::ranges::adjacent_find(plan.files, is_earlier_number);
  if (turn != plan.files.end())
    remark(
        "note: '{}' comes before '{}', as the files are named; import their folder to have them in the order "
        "of their numbers\n",
        *turn, *std::next(turn));
}

// What the files state for display: the turns that are applied, and what is not.
void tell_display(const FootagePlan& plan) {
  if (const std::string turns = describe_turns(plan); !turns.empty()) remark("note: {}\n", turns);
  if (plan.oblique)
    remark(
        "note: the files state that their pictures are turned for display by an angle that is no multiple of "
        "90 degrees, which is not applied; outputs show them as they are stored\n");
  if (!plan.primaries.empty())
    remark(
        "note: the primaries of the pictures are not those of BT.709 ({}), and colours are not converted; "
        "outputs show them less saturated than they were\n",
        plan.primaries);
}

void warn_of_copies(const FootagePlan& plan) {
  if (const std::string copies = describe_copies(plan); !copies.empty()) remark("warning: {}\n", copies);
}

// Cut footage is an error after all that is there was imported, as a cut recording is.
Result<void> tell_losses(const FootagePlan& plan) {
  std::optional<std::string> cut;
  for (const FootageLosses& losses : plan.losses)
    if (losses.lost.missing > 0 && !cut)
      cut = describe(losses);
    else
      remark("warning: {}\n", describe(losses));
  return cut ? Error{ErrorCode::Truncated, *cut} : Result<void>();
}

// Whether there is memory for it, before all of it is read: the first picture tells.
Result<void> admit_footage(Storage& storage, const FootageRequest& request, const Settings& settings) {
  const auto footage = TRY(open_footage(storage, request.files, request.framerate_hz));
  const auto is_video = [](const std::string& file) { return is_footage(file) && !is_still(file); };
  const bool stills = footage->still() && std::ranges::none_of(request.files, is_video);
  return admit_copy(
      settings, footage->camera(),
      {stills ? CopyKind::Stills : CopyKind::Video,
       stills ? most_waiting(request.files.size()) : RecordedLabels::kBeginning, settings.record.codec});
}

Result<void> import_footage(Surroundings& around, const ImportOptions& options, const Settings& settings) {
  const FootageRequest footage = TRY(with_files(around.storage, options.footage));
  if (!options.list) {
    TRY(options.kept.check(around.storage, files_of(footage),
                           {{"--output", options.output, OutputKind::Recording}}));
    TRY(admit_footage(around.storage, footage, settings));
  }
  const FootagePlan plan = TRY(plan_footage(around.storage, footage, around.stop));
  tell_order(plan);
  tell_display(plan);
  warn_of_copies(plan);
  if (options.list) {
    say("{}", described(plan));
    auto reader = TRY(open_planned(around.storage, footage, plan));
    TRY(judged_facts(around, options, std::move(reader), describe_pause(plan)));
    warn_of_phase(plan);
    return tell_losses(plan);
  }
  if (!plan.times.trouble.empty())
    remark("note: the frames come at {}, because {}\n", counted_per_second(plan.camera.framerate_hz, "frame"),
           plan.times.trouble);
  if (plan.origin == ExposureOrigin::Estimated)
    remark("note: the exposures are estimated, and relative to each other only\n");
  if (const std::string missing = describe_missing(plan); !missing.empty()) remark("note: {}\n", missing);
  auto reader = TRY(open_planned(around.storage, footage, plan));
  TRY(write_recording(around, options, settings, std::move(reader), describe_pause(plan)));
  warn_of_phase(plan);
  return tell_losses(plan);
}

// What --framerate takes: "" for a rate that a recording can have, else a clause that says so.
std::string takes_framerate(const std::string& text) {
  const auto rate_hz = parse_number<double>(text);
  if (!rate_hz) return fmt::format("takes frames per second, such as 30, not '{}'", text);
  CameraFacts camera;
  camera.framerate_hz = *rate_hz;
  return objection_to(camera).value_or("");
}

// Whether the import writes something or lists it, and not both.
Result<void> check_output(const ImportOptions& options) {
  if (options.list && (!options.output.empty() || options.kept.replaces()))
    return Error{
        ErrorCode::Invalid,
        "--list says what would be imported and writes nothing; leave out --list, or --output and --force"};
  if (!options.list && options.output.empty())
    return Error{ErrorCode::Invalid,
                 "no output file; give -o walk.mkv, or --list to see what would be imported"};
  return {};
}

// The flags that only a clip takes, or only other footage: a clip says its exposures itself.
Result<void> check_source_flags(const ImportOptions& options, bool clip) {
  const FootageRequest& footage = options.footage;
  if (clip && !(footage.shutter.empty() && footage.gain.empty() && footage.framerate_hz == 0))
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' says exposures and times itself; leave out --shutter, --gain and --framerate",
                    footage.files.front())};
  if (!clip && options.allow_outside)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is neither a clip.json nor a folder with one; leave out --allow-outside",
                             footage.files.front())};
  if (!footage.gain.empty() && footage.shutter == kAutoShutter)
    return Error{ErrorCode::Invalid, "--shutter auto estimates whole exposures; leave out --gain"};
  if (!footage.gain.empty() && footage.shutter.empty())
    return Error{ErrorCode::Invalid, "--gain goes with the exposure times of --shutter; give both"};
  return {};
}

Result<void> import_any(const ImportOptions& options, const Settings& settings, Surroundings& around) {
  TRY(check_output(options));
  TRY(check_recording_name(around.storage, "--output", options.output));
  const bool clip = TRY(is_clip(around.storage, options.footage.files));
  TRY(check_source_flags(options, clip));
  return clip ? import_clip(around, options, settings) : import_footage(around, options, settings);
}

}  // namespace

void add_import(CommandLine program, Verb& chosen) {
  auto options = std::make_shared<ImportOptions>();
  CommandLine verb = program.add_verb("import", "turn videos or pictures of another camera into a recording");
  FootageRequest& footage = options->footage;
  verb.add_option(
          "footage", footage.files,
          "videos and pictures, or a folder of them; or a clip.json that states each exposure, or its folder")
      .required()
      .check(names_input);
  verb.add_option("-o,--output", options->output, "the recording to write (.mkv)")
      .transform(named_at_start)
      .check(names_file);
  verb.add_option(
      "--shutter", footage.shutter,
      "the cycle of 1 to 4 exposure times, such as 1ms,4ms,16ms; auto: estimated from the pictures, "
      "relative [as EXIF states them]");
  verb.add_option("--gain", footage.gain, "gain of each exposure, ISO / 100, or one for all [1]");
  verb.add_option("--framerate", footage.framerate_hz,
                  "frames per second of stills [as the times of EXIF show, else 30] and of a video without "
                  "times [as it states]")
      .check(takes_framerate);
  verb.add_switch("--list", options->list, "say what would be imported, and write nothing");
  verb.add_switch("--strict", options->strict,
                  "fail where the pictures contradict an exposure, instead of relabelling or flagging it");
  verb.add_switch("--allow-outside", options->allow_outside,
                  "also read images that the clip.json names outside its own folder");
  options->kept.add_to(verb);
  options->settings =
      std::make_unique<SettingsFlags>(verb, std::vector<std::string>{"record.codec", "machine.memory_mib"});
  verb.on_chosen([options, &chosen] { chosen = with_settings(options, import_any); });
}

}  // namespace hdrcam
