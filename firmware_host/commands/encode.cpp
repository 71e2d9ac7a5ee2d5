// hdrcam encode out/%06d.exr -o x.mp4: HDR frames that exist become a video.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/ignored_flags.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/run/progress.h"
#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/hdr_video.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/sinks/sink_table.h"
#include "firmware_host/terminal.h"
#include "hal/clock.h"
#include "hal/core/counted.h"
#include "hal/core/folder_listing.h"
#include "hal/core/sound_facts.h"
#include "hal/core/stopwatch.h"
#include "hal/video/video_writer.h"
#include "render/scores/linear_pictures.h"

namespace hdrcam {
namespace {

constexpr double kUsualFramerate_hz = 30, kLeastFramerate_hz = 0.1, kMostFramerate_hz = 1000;
// That PQ can say, where a file does not say what its cycle could see.
constexpr double kBrightest_nits = 10000;

struct EncodeFlags {
  std::string frames;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

struct NumberedFile {
  std::uint64_t sequence;
  std::string path;
};

// The numbered frames that a folder holds: one of them, and the pattern that names them all.
struct FoundFrames {
  std::filesystem::path first, pattern;
};

// The pattern that names this file and those that are numbered alike; none where there is none, as where its
// name has a '%'.
std::optional<std::filesystem::path> pattern_around(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t digits = digits_at_end(stem);
  const std::string name = fmt::format("{}%0{}d.exr", stem.substr(0, stem.size() - digits), digits);
  std::filesystem::path pattern = file.parent_path() / name;
  if (!FramePattern::is_one(pattern.string())) return std::nullopt;
  return pattern;
}

// Of the shortest name, whose pattern fits the longer ones of its series too: f1.exr, f10.exr.
std::optional<FoundFrames> frames_in(const FolderListing& listing) {
  std::optional<FoundFrames> found;
  const auto comes_before = [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), std::string_view(a)) < std::pair(b.size(), std::string_view(b));
  };
  for (const std::filesystem::path& path : listing.paths()) {
    if (path.extension() != ".exr" || (found && !comes_before(path.string(), found->first.string())))
      continue;
    if (auto pattern = pattern_around(path)) found = {path, *std::move(pattern)};
  }
  return found;
}

// What a folder holds in place of the frames that are named, with what to write for it: the end of a
// sentence.
std::string other_frames_in(const FolderListing& listing) {
  const std::optional<FoundFrames> found = frames_in(listing);
  return found ? fmt::format("; there is '{}', for which write '{}'", found->first.string(),
                             found->pattern.string())
               : "";
}

// Of a name with a '%'.
Result<FramePattern> parsed_pattern(const std::string& text) {
  Result<FramePattern> pattern = FramePattern::parse("frames", text, ".exr");
  if (pattern) return pattern;
  const std::filesystem::path folder = std::filesystem::path(text).parent_path();
  const FolderListing listing(folder.empty() ? "." : folder.string());
  return Error{pattern.error().code, pattern.error().message + other_frames_in(listing)};
}

// text: as the user names the frames. A folder, whose name may have a '%', or one file of many, leads to the
// pattern.
Result<FramePattern> pattern_of(Storage& storage, const std::string& text) {
  const Result<FileFacts> facts = storage.look_at(text);
  const bool folder = facts && facts.value().kind == FileKind::Folder;
  if (!folder && text.find('%') != std::string::npos) return parsed_pattern(text);
  if (!facts) return facts.error();
  const std::filesystem::path named(text);
  const std::filesystem::path place = folder ? named : named.parent_path();
  const bool recording = named.extension() == ".mkv";
  const std::optional<FoundFrames> found = folder ? frames_in(FolderListing(text)) : std::nullopt;
  return Error{ErrorCode::Invalid,
               fmt::format("'{}' {}; name the frames by their pattern, such as '{}'{}", text,
                           folder ? "is a folder" : "names one file",
                           (found ? found->pattern : place / "%06d.exr").string(),
                           recording ? "; of a recording 'hdrcam replay' makes a video" : "")};
}

// In the order of their numbers.
Result<std::vector<NumberedFile>> files_of(const FramePattern& pattern, const std::string& text) {
  std::vector<NumberedFile> files;
  const FolderListing listing(pattern.folder());
  for (const std::filesystem::path& path : listing.paths())
    if (const auto sequence = pattern.sequence_of(path.filename().string()))
      files.push_back({*sequence, pattern.path(*sequence)});
  if (listing.failure() && !listing.is_missing()) return listing.cannot_read();
  if (files.empty())
    return Error{ErrorCode::NotFound,
                 fmt::format("there are no frames '{}'{}", text, other_frames_in(listing))};
  std::ranges::sort(files, {}, &NumberedFile::sequence);
  return files;
}

// A player can show what another program left in a file, but not what is no number.
float shown(float radiance) { return std::max(0.f, finite_or_bound(radiance)); }

// The colours of a file are taken for those of BT.709, whatever it states.
void warn_of_primaries(const ExrImage& image, const NumberedFile& file) {
  constexpr float kRounding = 1e-3f;
  const Chromaticities ours, theirs = image.attributes.chromaticities.value_or(ours);
  for (const auto of :
       {&Chromaticities::red, &Chromaticities::green, &Chromaticities::blue, &Chromaticities::white})
    for (std::size_t i = 0; i < 2; ++i)
      if (!(std::abs((theirs.*of)[i] - (ours.*of)[i]) <= kRounding))
        return remark(
            "warning: '{}' states other primaries than those of BT.709, and colours are not converted; "
            "convert the frames first\n",
            file.path);
}

// wanted: as --framerate says; 0: as the first file says, and so where that states its time, for frames keep
// their times.
Result<double> framerate_of(const ExrImage& image, const NumberedFile& file, double wanted_hz) {
  const std::optional<double>& own_hz = image.attributes.framerate_hz;
  const double stated_hz = own_hz.value_or(kUsualFramerate_hz);
  const bool is_possible = stated_hz >= kLeastFramerate_hz && stated_hz <= kMostFramerate_hz;
  const bool goes_with_times = own_hz && run_facts_of(image.attributes).since_start_s;
  if (wanted_hz > 0 && !(is_possible && goes_with_times)) return wanted_hz;
  if (is_possible) return stated_hz;
  // A fraction of zeros is no number, whose sign would be the processor's.
  const std::string stated = std::isnan(stated_hz) ? "0/0" : fmt::format("{:g}", stated_hz);
  return Error{ErrorCode::Invalid, fmt::format("'{}' states {} frames per second, {:g}..{:g} are possible; "
                                               "give --framerate 30",
                                               file.path, stated, kLeastFramerate_hz, kMostFramerate_hz)};
}

// Who says the luminance of radiance 1.
enum class WhiteOrigin { Settings, Files };

// Files say it where --white does not. What has no absolute light needs none.
WhiteOrigin white_origin_of(const SettingsFlags& flags, const VideoOptions& video,
                            const std::string& output) {
  const bool given = !flags.given({"video.white"}).empty() || video.white_nits != VideoOptions{}.white_nits;
  const bool absolute =
      video.transfer != VideoTransfer::Sdr && (output != kStandardOutput || video.pipe != PipeFormat::Half);
  return absolute && !given ? WhiteOrigin::Files : WhiteOrigin::Settings;
}

// As the first file says, or the usual one.
Result<double> white_nits_of(const ExrImage& image, const NumberedFile& file, const VideoOptions& video) {
  constexpr double kLeast_nits = 0.001;
  const double stated_nits = image.attributes.white_cd_m2.value_or(video.white_nits);
  if (stated_nits >= kLeast_nits && stated_nits <= video.peak_nits) return stated_nits;
  return Error{ErrorCode::Invalid,
               fmt::format("'{}' states that radiance 1 is {:g} cd/m2 (whiteLuminance), {:g} to {:g}, the "
                           "--peak, are possible; give another --peak, or --white {:g}",
                           file.path, stated_nits, kLeast_nits, video.peak_nits, video.white_nits)};
}

Result<HdrFrame> frame_of(const ExrImage& image, const NumberedFile& file, std::uint64_t first,
                          double white_nits, double framerate_hz) {
  HdrFrame frame;
  frame.facts.sequence = file.sequence;
  frame.radiance = Image<float>(3, image.samples.rows(), image.samples.cols());
  for (int c = 0; c < 3; ++c) {
    const auto channel = image.find(exr_channel::kRadiance[c]);
    if (!channel)
      return Error{ErrorCode::Unsupported, fmt::format("'{}' has no channel {}; HDR frames have R, G and B",
                                                       file.path, exr_channel::kRadiance[c])};
    std::transform(image.samples.plane(*channel), image.samples.plane(*channel) + image.samples.plane_size(),
                   frame.radiance.plane(c), shown);
  }
  const RunFacts facts = run_facts_of(image.attributes);
  const double regular_s = std::min(static_cast<double>(file.sequence - first) / framerate_hz, kLatest_s);
  frame.facts.timestamp = Instant::from_seconds(facts.since_start_s.value_or(regular_s));
  frame.white = static_cast<float>(facts.white.value_or(kBrightest_nits / white_nits));
  return frame;
}

// The times that files state go on from one to the next, or the second take would be shown in no time. Files
// that cannot be read are left to the one who needs their pictures, as those behind a stop are.
Result<void> check_one_take(Storage& storage, std::span<const NumberedFile> files,
                            const std::atomic<bool>& stop) {
  std::optional<double> last_s;
  const NumberedFile* last = nullptr;
  for (const NumberedFile& file : files) {
    if (stop) break;
    const auto attributes = read_exr_attributes(storage, file.path);
    if (!attributes) continue;
    const std::optional<double> time_s = run_facts_of(attributes.value()).since_start_s;
    if (last_s && time_s && *time_s <= *last_s)
      return Error{
          ErrorCode::Invalid,
          fmt::format("'{}' is not later than '{}' before it: they are of two takes; move the frames of "
                      "one into a folder of their own",
                      file.path, last->path)};
    if (time_s) last_s = time_s, last = &file;
  }
  return {};
}

// Errors: Invalid where no video is named.
Result<void> check_video_named(const std::string& output) {
  if (output.empty())
    return Error{ErrorCode::Invalid,
                 "no video; give -o x.mp4 (.mov, .mkv), or - for the standard output; see 'hdrcam encode "
                 "--help'"};
  if (output != kStandardOutput && !video_container_of(output))
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is not the name of a video; give -o x.mp4 (.mov, .mkv), or - for "
                             "the standard output",
                             output)};
  return {};
}

// A file of settings serves other verbs, too: what it says of a camera or of other outputs does not count.
Result<void> check_flags(const EncodeFlags& flags, const Settings& settings, const std::string& output) {
  Settings used;
  used.output.paths.emplace(sink_name::kFrames, output);
  used.video = settings.video;
  TRY(check_ignored_flags(*flags.settings, used));
  if (settings.video.pipe != PipeFormat::Half) TRY(check_video(settings.video));
  return output == kStandardOutput ? Result<void>() : check_rate_factor(settings.video);
}

// The video, which begins with the first file. Thread-bound.
class EncodedFiles {
 public:
  EncodedFiles(const Settings& settings, WhiteOrigin white, std::string output, NumberedFile first,
               Storage& storage)
      : video_(settings.video),
        framerate_hz_(settings.camera.framerate_hz),
        white_(white),
        output_(std::move(output)),
        first_(std::move(first)),
        storage_(storage) {}

  Result<void> add(const NumberedFile& file) {
    const ExrImage image = TRY(read_exr(storage_, file.path));
    if (!sink_) TRY(begin(image, file));
    TRY(check_size(image, file));
    warn_of_white(image, file);
    const HdrFrame frame =
        TRY(frame_of(image, file, first_.sequence, video_.white_nits, camera_.framerate_hz));
    warn_of_pause(frame.facts.timestamp, file);
    return sink_->emit({frame, ExposedFrame{}, FrameRecord{}});
  }
  // Whether the files have times and a rate, and another one was asked for.
  bool keeps_own_rate() const {
    constexpr double kRounding = 1e-3;  // 29.97 is 30000/1001
    return sink_ && std::abs(framerate_hz_ - camera_.framerate_hz) > kRounding * camera_.framerate_hz &&
           framerate_hz_ > 0;
  }
  // Nothing where none was added.
  Result<void> finish() { return sink_ ? sink_->finish() : Result<void>{}; }

 private:
  Result<void> begin(const ExrImage& image, const NumberedFile& file) {
    warn_of_primaries(image, file);
    camera_.height = image.samples.rows(), camera_.width = image.samples.cols();
    camera_.framerate_hz = TRY(framerate_of(image, file, framerate_hz_));
    stated_white_ = image.attributes.white_cd_m2;
    if (white_ == WhiteOrigin::Files) video_.white_nits = TRY(white_nits_of(image, file, video_));
    sink_ = TRY(open_sink(sink_name::kFrames,
                          {.path = output_, .camera = camera_, .video = video_, .storage = storage_}));
    return {};
  }

  // By name, where the sinks know numbers alone.
  Result<void> check_size(const ExrImage& image, const NumberedFile& file) const {
    if (image.samples.rows() == camera_.height && image.samples.cols() == camera_.width) return {};
    return Error{
        ErrorCode::SizeChanged,
        fmt::format("'{}' has {}x{} pixels, and '{}', the first frame, {}x{}; give frames of one size",
                    file.path, image.samples.cols(), image.samples.rows(), first_.path, camera_.width,
                    camera_.height)};
  }

  // One scale for the whole video.
  void warn_of_white(const ExrImage& image, const NumberedFile& file) {
    if (white_ != WhiteOrigin::Files || image.attributes.white_cd_m2 == stated_white_) return;
    if (!std::exchange(warned_of_white_, true))
      remark(
          "warning: '{}' states another luminance of radiance 1 than the first frame, which counts for all; "
          "convert the frames first, or give --white\n",
          file.path);
  }

  // Numbers such as those of nanoseconds would show each frame for days.
  void warn_of_pause(Instant time, const NumberedFile& file) {
    constexpr Duration kLongest = std::chrono::minutes(10);
    const Duration pause = time - std::exchange(last_time_, time).value_or(time);
    if (pause > kLongest && !std::exchange(warned_of_pause_, true))
      remark(
          "warning: '{}' comes {:.0f} s after the frame before it, by its time or its number; where that is "
          "wrong, number the frames one by one\n",
          file.path, to_seconds(pause));
  }

  VideoOptions video_;  // its white: that of the files, where they say it
  const double framerate_hz_;
  const WhiteOrigin white_;
  const std::string output_;
  const NumberedFile first_;
  Storage& storage_;
  CameraFacts camera_;
  std::optional<double> stated_white_;  // by the first file, cd/m2
  bool warned_of_white_ = false, warned_of_pause_ = false;
  std::optional<Instant> last_time_;
  std::unique_ptr<FrameSink> sink_;
};

Error stopped_after(std::size_t frames, std::size_t all) {
  if (frames == 0) return {ErrorCode::Interrupted, "stopped before the first frame"};
  return {ErrorCode::Interrupted,
          fmt::format("stopped after {} of {} frames; they are complete", frames, all)};
}

Result<void> encode(const EncodeFlags& flags, const Settings& settings, Surroundings& around) {
  const std::string output =
      with_start_time(settings, posix_clock().wall_time()).output.path(sink_name::kFrames);
  TRY(check_video_named(output));
  TRY(check_flags(flags, settings, output));
  const FramePattern pattern = TRY(pattern_of(around.storage, flags.frames));
  const std::vector<NumberedFile> files = TRY(files_of(pattern, flags.frames));
  TRY(flags.kept.check(around.storage, {},
                       {{"--output", output == kStandardOutput ? "" : output, OutputKind::Recording}}));
  TRY(check_one_take(around.storage, files, around.stop));

  EncodedFiles video(settings, white_origin_of(*flags.settings, settings.video, output), output,
                     files.front(), around.storage);
  Progress progress(stderr, static_cast<int>(files.size()));
  Result<void> encoded;
  std::size_t frames = 0;  // in the video
  while (frames < files.size() && !around.stop) {
    Stopwatch watch;
    encoded = video.add(files[frames]);
    if (!encoded) break;
    ++frames;
    progress.frame_done(watch.lap_ms(), std::nullopt);
  }
  if (const Result<void> finished = video.finish(); encoded && !finished) encoded = finished;
  if (video.keeps_own_rate() && !flags.settings->given({"camera.framerate"}).empty())
    remark("note: the files state their times, and --framerate is for files that state none\n");
  if (encoded && frames > 0 && output != kStandardOutput) say("{}: {}\n", output, counted(frames, "frame"));
  if (encoded && frames < files.size()) return stopped_after(frames, files.size());
  return encoded;
}

}  // namespace

void add_encode(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<EncodeFlags>();
  CommandLine verb = program.add_verb("encode", "turn HDR frames that exist into a video");
  verb.add_option("frames", flags->frames, "the OpenEXR files, numbered: out/%06d.exr")
      .required()
      .check(names_input);
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(
      verb, std::vector<std::string>{"output.frames", "camera.framerate", "video.transfer", "video.codec",
                                     "video.white", "video.peak", "video.crf", "video.pipe_format"});
  verb.flag("--output").describe("the video: out.mp4 (.mov, .mkv); or -, the standard output");
  verb.flag("--framerate")
      .describe("frames per second of files that state no time (0.1..1000; 0: as they state it, or 30)")
      .group(title(SettingGroup::Output));
  verb.flag("--white").describe(
      "luminance of radiance 1 in HDR videos, cd/m2 (1..10000; not given: as the first file states it, or "
      "203)");
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, encode); });
}

}  // namespace hdrcam
