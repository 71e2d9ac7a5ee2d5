#include "firmware_host/live/capture_setup.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>

#include "hal/clock.h"
#include "hal/core/parse_number.h"
#include "hal/core/split_text.h"
#include "hal/jpeg_decoder.h"
#include "hal/real/enumerate.h"
#include "hal/replay/replayed_camera.h"

namespace hdrcam {
namespace {

constexpr std::string_view kSim = "sim:", kReplay = "replay:";
constexpr int kUsualArea_px = 640 * 480;  // at most, where no size is set: what the fit keeps up with

// How finely chroma is sampled: 4:4:4 before 4:2:2 before 4:2:0.
int chroma_rank(PixelFormat format) {
  switch (format) {
    case PixelFormat::Rgb24:
    case PixelFormat::Bgr24:
      return 3;
    case PixelFormat::Yuyv:
    case PixelFormat::Uyvy:
      return 2;
    case PixelFormat::Nv12:
      return 1;
    default:
      return 0;
  }
}

// Larger is better: colour before mono, raw before processed, more bits before fewer, full before subsampled
// chroma, then as listed.
std::tuple<bool, bool, int, int, int> rank_of(PixelFormat format) {
  const PixelCodes codes = codes_of(format);
  return {codes.layout != PixelLayout::Mono, codes.linear, codes.bits, chroma_rank(format),
          -static_cast<int>(format)};
}

void add_new(std::string text, std::vector<std::string>& texts) {
  if (std::find(texts.begin(), texts.end(), text) == texts.end()) texts.push_back(std::move(text));
}

std::string listed(std::vector<std::string> texts) {
  constexpr std::size_t kShown = 12;
  const std::size_t hidden = texts.size() > kShown ? texts.size() - kShown : 0;
  texts.resize(texts.size() - hidden);
  return fmt::format("{}{}", fmt::join(texts, ", "), hidden > 0 ? fmt::format(" and {} more", hidden) : "");
}

std::string modes_of(const CameraCapabilities& camera) {
  std::vector<std::string> texts;
  for (const StreamMode& mode : camera.modes)
    add_new(fmt::format("{} {}x{}", name(mode.format), mode.width, mode.height), texts);
  return listed(std::move(texts));
}

// Smaller is better. Of a size that is set: how far the mode's is from it. Else whether it is larger than
// usual; then, of usual sizes the largest, of larger ones the smallest.
std::pair<long, long> misfit(const Settings::Camera& wanted, const StreamMode& mode) {
  if (wanted.width > 0 || wanted.height > 0)
    return {(wanted.width > 0 ? std::abs(mode.width - wanted.width) : 0) +
                (wanted.height > 0 ? std::abs(mode.height - wanted.height) : 0),
            0};
  const long area = static_cast<long>(mode.width) * mode.height;
  return area <= kUsualArea_px ? std::pair{0L, -area} : std::pair{1L, area};
}

// True of all modes where no size is set.
bool has_set_size(const Settings::Camera& wanted, const StreamMode& mode) {
  return (wanted.width <= 0 || mode.width == wanted.width) &&
         (wanted.height <= 0 || mode.height == wanted.height);
}

}  // namespace

bool is_simulated(const std::string& id) { return id.starts_with(kSim); }
bool is_replayed(const std::string& id) { return id.starts_with(kReplay); }
std::string replayed_file(const std::string& id) { return id.substr(kReplay.size()); }

Result<std::unique_ptr<Camera>> open_camera(const std::string& id, Storage& storage,
                                            const SimulatedWiring& wiring) {
  if (is_simulated(id)) return open_simulated_camera(std::string_view(id).substr(kSim.size()), wiring);
  if (is_replayed(id))
    return open_replayed_camera(storage, replayed_file(id), ReplayPace::AsRecorded, posix_clock());
  if (const auto file = storage.look_at(id);
      file && file.value().kind == FileKind::Regular && !id.starts_with("/dev/"))
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' is a file and not a camera; a recording is --camera {}{}", id, kReplay, id)};
  return open_real_camera(id);
}

Result<StreamMode> mode_for(const Settings::Camera& wanted, const CameraCapabilities& camera) {
  std::optional<PixelFormat> format;
  if (!wanted.format.empty()) {
    format = pixel_format(wanted.format);
    if (!format || std::none_of(camera.modes.begin(), camera.modes.end(),
                                [&](const StreamMode& mode) { return mode.format == *format; }))
      return Error{ErrorCode::Unsupported, fmt::format("'{}' has no format '{}'; it offers {}", camera.id,
                                                       wanted.format, modes_of(camera))};
  }
  const StreamMode* best = nullptr;
  const auto better = [&](const StreamMode& a, const StreamMode& b) {
    if (has_set_size(wanted, a) != has_set_size(wanted, b)) return has_set_size(wanted, a);
    if (rank_of(a.format) != rank_of(b.format)) return rank_of(a.format) > rank_of(b.format);
    return misfit(wanted, a) < misfit(wanted, b);
  };
  for (const StreamMode& mode : camera.modes)
    if ((!format || mode.format == *format) && (best == nullptr || better(mode, *best))) best = &mode;
  if (best == nullptr)
    return Error{
        ErrorCode::Unsupported,
        fmt::format("'{}' has no format that hdrcam reads; 'hdrcam list' shows what it has", camera.id)};
  StreamMode mode = *best;
  if (wanted.width > 0) mode.width = wanted.width;
  if (wanted.height > 0) mode.height = wanted.height;
  mode.frame_duration = wanted.framerate_hz > 0 ? from_seconds(1 / wanted.framerate_hz)
                                                : std::max(mode.frame_duration, camera.usual_frame_duration);
  return mode;
}

std::string sizes_of(const CameraCapabilities& camera, const StreamMode& taken) {
  const auto text_of = [](const StreamMode& mode) { return fmt::format("{}x{}", mode.width, mode.height); };
  std::vector<std::string> texts;
  for (const StreamMode& mode : camera.modes)
    if (mode.format == taken.format) add_new(text_of(mode), texts);
  const bool lists_all = std::find(texts.begin(), texts.end(), text_of(taken)) != texts.end();
  return lists_all && texts.size() > 1 ? listed(std::move(texts)) : "";
}

Result<ControlDelays> parse_delays(std::string_view text) {
  const auto comma = text.find(',');
  const auto number = [](std::string_view part) -> std::optional<int> {
    const auto frames = parse_number<int>(trimmed(part));
    return frames && *frames >= 0 ? frames : std::nullopt;
  };
  const auto exposure = number(text.substr(0, comma));
  const auto gain = comma == std::string_view::npos ? exposure : number(text.substr(comma + 1));
  if (!exposure || !gain)
    return Error{
        ErrorCode::Invalid,
        fmt::format("'{}' is not a control delay; write the frames of exposure and gain, like 2,1", text)};
  return ControlDelays{*exposure, *gain};
}

Result<CaptureSetup> capture_setup(const Settings& settings, const CameraCapabilities& camera) {
  CaptureSetup setup;
  CaptureOptions& options = setup.options;
  options.mode = TRY(mode_for(settings.camera, camera));
  options.buffers = settings.camera.buffers;
  options.adapt = settings.schedule.adapt;
  if (!settings.camera.control_delay.empty())
    options.delays = TRY(parse_delays(settings.camera.control_delay));
  if (settings.camera.black_level >= 0) options.black_level = BlackLevel(settings.camera.black_level);
  if (settings.camera.timestamp != StampMeaning::AsDriverSays)
    options.timestamp_mark = settings.camera.timestamp == StampMeaning::ExposureBegin
                                 ? TimestampMark::ExposureBegin
                                 : TimestampMark::ExposureEnd;
  options.clock = &posix_clock();
  options.unpack.yuv_range = settings.camera.yuv_range;
  options.unpack.decode_jpeg = jpeg_decoder();
  if (!settings.sync.line.empty()) options.strobe = settings.sync.strobe;
  options.strobe_after_timestamp = TRY(parse_signed_duration(settings.sync.strobe_delay));
  constexpr int kPatience = 10;  // frames
  options.patience = std::max(options.patience, kPatience * options.mode.frame_duration);
  setup.cycle = TRY(parse_exposures(settings.schedule.shutter, settings.schedule.gain, usual_gain(camera)));
  setup.mains = settings.schedule.mains;
  return setup;
}

}  // namespace hdrcam
