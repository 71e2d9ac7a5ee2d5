#include "firmware_host/sinks/output_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "firmware_host/sinks/dash.h"
#include "firmware_host/sinks/earlier_frames.h"
#include "firmware_host/sinks/frame_ledger.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/output_folder.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "hal/core/counted.h"
#include "hal/core/file_extension.h"
#include "hal/footage/footage.h"

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSceneExtension = ".hdrscene", kSettingsExtension = ".toml";

// The names that numbered frames may get.
struct NameSet {
  std::string folder;  // without symbolic links
  FramePattern pattern;
  std::string text;  // the pattern as it was given, or in that folder where the given one is not there yet
};

// Of /dev/null, with which other programs are timed, and of a FIFO.
Error takes_no_files(const NamedOutput& frames) {
  return {ErrorCode::Invalid,
          fmt::format("{} '{}' is a device or a FIFO, which takes no numbered files; leave it out and give "
                      "--stats stats.json to time a run without them{}",
                      frames.flag, frames.path,
                      frames.flag == "--output" ? ", or give --output - to pipe the frames" : "")};
}

Result<NameSet> names_of(Storage& storage, const NamedOutput& frames) {
  const fs::path path(frames.path);
  const std::string own = path.extension().string();
  auto pattern =
      FramePattern::parse(frames.flag, frames.path, frames.extension.empty() ? own : frames.extension);
  if (!pattern) {
    const auto there = storage.look_at(frames.path);
    return there && there.value().kind == FileKind::Other ? takes_no_files(frames) : pattern.error();
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  FileFacts there = TRY(storage.look_at(folder.string()));
  fs::path text = path;
  if (there.kind == FileKind::Missing) {  // by that name: "/tmp/new/..", while there is no "new"
    there = TRY(storage.look_at(there.real_path));
    text = there.real_path / path.filename();
  }
  fs::path real(there.real_path);
  if (!real.has_filename()) real = real.parent_path();  // of "/tmp/"
  return NameSet{real.string(), std::move(pattern).value(), text.string()};
}

// The place of an input or an output on the disk.
struct Place {
  std::string words;  // "the recording that is read", "--stats"
  std::string path;
  FileFacts facts;
  std::optional<NameSet> names;       // of numbered frames
  InputKind input = InputKind::File;  // an output is none
};

bool is_below(const std::string& real_path, const std::string& folder) {
  return real_path.starts_with(folder.ends_with('/') ? folder : folder + '/');
}

// input: a folder that is read
bool is_in(const Place& output, const Place& input) {
  const std::string& folder = input.facts.real_path;
  if (!output.names) return is_below(output.facts.real_path, folder);
  return output.names->folder == folder || is_below(output.names->folder, folder);
}

bool meet(const Place& a, const Place& b) {
  if (b.input == InputKind::Folder) return is_in(a, b);
  if (a.names && b.names)
    return a.names->folder == b.names->folder && a.names->pattern.same_names_but_for_digits(b.names->pattern);
  const auto in = [](const NameSet& names, const Place& file) {
    const fs::path real(file.facts.real_path);
    return real.parent_path() == names.folder && names.pattern.fits(real.filename().string());
  };
  if (a.names) return in(*a.names, b);
  if (b.names) return in(*b.names, a);
  return a.facts.kind != FileKind::Other && same_file(a.facts, b.facts);
}

// Whether the second output goes into a folder that would have to be made where the first one's file goes.
bool is_folder_of(const Place& file, const Place& other) {
  if (file.names || file.facts.kind != FileKind::Missing) return false;
  const std::string folder =
      other.names ? other.names->folder : fs::path(other.facts.real_path).parent_path().string();
  return folder == file.facts.real_path || is_below(folder, file.facts.real_path);
}

// Between two outputs, or an output and an input.
Result<void> check_apart(const Place& place, const Place& other) {
  if (meet(place, other))
    return Error{ErrorCode::Invalid, fmt::format("{} '{}' would overwrite {} '{}'; name another file",
                                                 place.words, place.path, other.words, other.path)};
  for (const auto& [file, within] : {std::pair(&place, &other), std::pair(&other, &place)})
    if (is_folder_of(*file, *within))
      return Error{
          ErrorCode::Invalid,
          fmt::format("{} '{}' is a file, and {} '{}' needs a folder of that name; name another file",
                      file->words, file->path, within->words, within->path)};
  return {};
}

Result<Place> place_of(Storage& storage, const NamedInput& input) {
  return Place{input.what, input.path, TRY(storage.look_at(input.path)), std::nullopt, input.kind};
}

Result<Place> place_of(Storage& storage, const NamedOutput& output) {
  Place place{output.flag, output.path, {}, std::nullopt};
  if (output.kind == OutputKind::Frames) {
    place.names = TRY(names_of(storage, output));
    return place;
  }
  if (output.path == kStandardOutput) return not_to_standard_output(output.flag);
  if (output.path.ends_with('/'))
    return Error{ErrorCode::Invalid,
                 fmt::format("{} '{}' names a folder; name a file in it", output.flag, output.path)};
  place.facts = TRY(storage.look_at(output.path));
  if (place.facts.kind != FileKind::Other && holds_frame_number(output.path))
    return Error{ErrorCode::Invalid,
                 fmt::format("{} '{}' has a frame number in its name, and is one file; name it without the "
                             "number",
                             output.flag, output.path)};
  return place;
}

// The time of the start has replaced {start}: any other word in braces is a misspelt one, but in the name of
// what is there already.
Result<void> check_words(Storage& storage, const NamedOutput& output) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ_abcdefghijklmnopqrstuvwxyz";
  const std::string& path = output.path;
  for (std::size_t open = path.find('{'); open != std::string::npos; open = path.find('{', open + 1)) {
    const std::size_t close = path.find_first_not_of(kLetters, open + 1);
    if (close == std::string::npos || close == open + 1 || path[close] != '}') continue;
    if (TRY(storage.look_at(path.substr(0, path.find('/', close)))).kind != FileKind::Missing) continue;
    return Error{ErrorCode::Invalid,
                 fmt::format("{} '{}' has {} in its name, which stands for nothing; write {{start}} for the "
                             "time at which the run starts",
                             output.flag, path, path.substr(open, close + 1 - open))};
  }
  return {};
}

// Its name ends in three digits or more, as the names of frames and of a camera's pictures do.
bool is_numbered(const std::string& path) {
  constexpr std::size_t kFewestDigits = 3;
  return digits_at_end(fs::path(path).stem().string()) >= kFewestDigits;
}

Result<void> check_earlier_work_stays(Storage& storage, const Place& place, OutputKind kind) {
  if (kind == OutputKind::Picture && place.facts.kind == FileKind::Regular &&
      is_numbered(place.facts.real_path))
    return Error{ErrorCode::Exists,
                 fmt::format("{} '{}' exists already and is numbered as a frame is; name another file, or "
                             "replace it with --force",
                             place.words, place.path)};
  const bool is_kept = kind != OutputKind::Frames && kind != OutputKind::Page && kind != OutputKind::Picture;
  if (is_kept && place.facts.kind == FileKind::Regular)
    return Error{ErrorCode::Exists, fmt::format("{} '{}' exists already; name another place, or replace it "
                                                "with --force",
                                                place.words, place.path)};
  if (!place.names) return {};
  const EarlierFrames earlier(storage, place.names->text);
  if (const Result<void>& listed = earlier.listed(); !listed)
    return Error{
        listed.error().code,
        fmt::format("{} '{}' may replace earlier files: {}; make the folder readable, or name another",
                    place.words, place.path, listed.error().message),
        listed.error().sys_errno};
  if (earlier.count() > 0)
    return Error{
        ErrorCode::Exists,
        fmt::format("{} '{}' would mix with {}, '{}' among them; name another folder, "
                    "or replace them with --force",
                    place.words, place.path, counted(earlier.count(), "earlier file"), earlier.first())};
  return {};
}

// Of a clip, or settings and calibrations.
bool describes_work(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name == "clip.json" || name == "gt.json" || lower_extension(path) == kSettingsExtension;
}

// For other tools; a file of poses that has a name of its own is not known for one.
bool holds_poses(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name == "transforms.json" || std::ranges::find(kColmapFiles, name) != kColmapFiles.end();
}

// A page may replace a page, a picture of the run such a picture, a scene a scene, a document a document,
// settings settings, poses poses, and a list a list, but never a frame, footage, a recording or what
// describes them that was named by mistake.
Result<void> check_no_other_work_is_replaced(const Place& place, OutputKind kind) {
  if (kind == OutputKind::Frames || kind == OutputKind::Recording) return {};
  if (place.facts.kind != FileKind::Regular) return {};
  const std::string& path = place.facts.real_path;
  const std::string extension = lower_extension(path);
  const bool own = (kind == OutputKind::Picture && extension == ".png") ||
                   (kind == OutputKind::Scene && extension == kSceneExtension) ||
                   (kind == OutputKind::Settings && extension == kSettingsExtension) ||
                   (kind == OutputKind::Poses && holds_poses(path)) ||
                   (kind == OutputKind::List && FrameLedger::is_one(path));
  const bool work = is_footage(path) || extension == ".exr" || extension == ".flo" ||
                    extension == kSceneExtension || FrameLedger::is_one(path) ||
                    (kind != OutputKind::Document && (describes_work(path) || holds_poses(path)));
  if (own || !work) return {};
  const char* replaced = describes_work(path)           ? "a clip or settings"
                         : holds_poses(path)            ? "the poses of pictures"
                         : FrameLedger::is_one(path)    ? "the list of an earlier run's frames"
                         : extension == kSceneExtension ? "a saved scene"
                                                        : "a picture or a recording";
  return Error{ErrorCode::Invalid,
               fmt::format("{} '{}' would replace {}; name another file", place.words, place.path, replaced)};
}

// By its name a later run knows a saved scene, and lets no page replace it; a pipe or a device may have any.
Result<void> check_named_as_scene(const Place& place, OutputKind kind) {
  if (kind != OutputKind::Scene || place.facts.kind == FileKind::Other) return {};
  if (lower_extension(place.path) == kSceneExtension) return {};
  return Error{ErrorCode::Invalid, fmt::format("{} '{}' is not the name of a saved scene; name it scene{}",
                                               place.words, place.path, kSceneExtension)};
}

// A message names the path once: what the storage says of it comes without its own "cannot write 'PATH'".
std::string reason_of(const std::string& message, const std::string& path) {
  const std::string said = fmt::format("cannot write '{}': ", path);
  return message.starts_with(said) ? message.substr(said.size()) + "; name another place" : message;
}

}  // namespace

Result<void> check_outputs(Storage& storage, std::span<const NamedInput> inputs,
                           std::span<const NamedOutput> outputs, Overwrite overwrite) {
  std::vector<Place> taken;
  for (const NamedInput& input : inputs) taken.push_back(TRY(place_of(storage, input)));
  for (const NamedOutput& output : outputs) {
    if (output.path.empty()) continue;
    TRY(check_words(storage, output));
    Place place = TRY(place_of(storage, output));
    if (!place.names && place.facts.kind == FileKind::Missing)  // "new/../walk.mkv", while there is no "new"
      place.facts = TRY(storage.look_at(place.facts.real_path));
    for (const Place& other : taken) TRY(check_apart(place, other));
    TRY(check_no_other_work_is_replaced(place, output.kind));
    TRY(check_named_as_scene(place, output.kind));
    if (overwrite == Overwrite::Refuse) TRY(check_earlier_work_stays(storage, place, output.kind));
    taken.push_back(std::move(place));
  }
  return {};
}

Result<void> make_room_for(Storage& storage, std::span<const NamedOutput> outputs) {
  for (const NamedOutput& output : outputs) {
    if (output.path.empty()) continue;
    TRY(make_folder_of(storage, output.path));
    if (TRY(storage.look_at(output.path)).kind == FileKind::Other) continue;  // written through
    const FileInMaking trial = TRY(FileInMaking::beside(storage, output.path));
    if (const auto made = trial.as_asked(storage.create(trial.path(), Creation::New)); !made)
      return Error{made.error().code,
                   fmt::format("{} '{}' cannot be written: {}", output.flag, output.path,
                               reason_of(made.error().message, output.path)),
                   made.error().sys_errno};
  }
  return {};
}

}  // namespace hdrcam
