#include "firmware_host/settings/setting_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <type_traits>

#include "firmware_host/settings/suggestion.h"

namespace hdrcam {
namespace {

constexpr double kMostInt = std::numeric_limits<int>::max();

template <auto kGroup, auto kMember>
constexpr auto place_of() {
  using T = std::remove_cvref_t<decltype(std::declval<Settings>().*kGroup.*kMember)>;
  return SettingPlace<T>{[](const Settings& s) -> const T& { return s.*kGroup.*kMember; },
                         [](Settings& s) -> T& { return s.*kGroup.*kMember; }};
}

template <auto kMember>
constexpr auto kCamera = place_of<&Settings::camera, kMember>();
template <auto kMember>
constexpr auto kSchedule = place_of<&Settings::schedule, kMember>();
template <auto kMember>
constexpr auto kSync = place_of<&Settings::sync, kMember>();
template <auto kMember>
constexpr auto kFit = place_of<&Settings::fit, kMember>();
template <auto kMember>
constexpr auto kOutput = place_of<&Settings::output, kMember>();
template <auto kMember>
constexpr auto kRecord = place_of<&Settings::record, kMember>();

using Text = SettingPlace<std::string>;

template <class T>
SettingField any(SettingPlace<T> place, const char* key, const char* flag, const char* about,
                 const char* unset = "") {
  SettingField field;
  field.place = place;
  field.key = key, field.flag = flag;
  field.about = about, field.unset = unset;
  return field;
}

SettingField list(Text place, const char* key, const char* flag, const char* about, const char* unset = "") {
  SettingField field = any(place, key, flag, about, unset);
  field.list = true;
  return field;
}

SettingField choice(Text place, const char* key, const char* flag, const char* about,
                    std::vector<std::string> choices) {
  SettingField field = any(place, key, flag, about);
  field.choices = std::move(choices);
  return field;
}

template <class T>
SettingField number(SettingPlace<T> place, const char* key, const char* flag, const char* about,
                    SettingRange range, const char* unset = "") {
  SettingField field = any(place, key, flag, about, unset);
  field.range = range;
  return field;
}

std::vector<SettingField> camera_fields() {
  using C = Settings::Camera;
  return {
      any(kCamera<&C::id>, "camera.id", "--camera", "a device, sim:SCENE or replay:FILE", "the only camera"),
      any(kCamera<&C::format>, "camera.format", "--format", "pixel format, such as YUYV",
          "the one that keeps most of the sensor's codes"),
      number(kCamera<&C::width>, "camera.width", "--width", "pixels of a row", {16, 65535, 0},
             "the largest of up to 640x480"),
      number(kCamera<&C::height>, "camera.height", "--height", "rows", {16, 65535, 0},
             "the largest of up to 640x480"),
      number(kCamera<&C::framerate_hz>, "camera.framerate", "--framerate", "frames per second",
             {0.1, 1000, 0}, "as the camera usually runs, 30"),
      number(kCamera<&C::buffers>, "camera.buffers", "--buffers", "requests under way", {4, 32, {}}),
      list(kCamera<&C::control_delay>, "camera.control_delay", "--control-delay",
           "frames until an exposure and a gain act, such as 2,1", "what the driver says"),
      number(kCamera<&C::black_level>, "camera.black_level", "--black-level",
             "black level of raw formats, in codes of 255", {0, 255, -1}, "of the table of sensors"),
      choice(kCamera<&C::timestamp>, "camera.timestamp", "--timestamp",
             "which moment of an exposure the driver stamps; driver: as it says", {"driver", "begin", "end"}),
      choice(kCamera<&C::yuv_range>, "camera.yuv_range", "--yuv-range",
             "luma of YUV formats: limited is 16..235, full is 0..255", {"limited", "full"}),
  };
}

std::vector<SettingField> schedule_fields() {
  using S = Settings::Schedule;
  return {
      list(kSchedule<&S::shutter>, "schedule.shutter", "--shutter",
           "the cycle of 1 to 4 exposure times, such as 250us, 4ms or 1/60"),
      list(kSchedule<&S::gain>, "schedule.gain", "--gain", "analogue gains of the cycle, or one for all",
           "1"),
      any(kSchedule<&S::adapt>, "schedule.adapt", "--adapt",
          "the cycle follows the light: highlights kept in the shortest, shadows in the longest exposure"),
      choice(kSchedule<&S::mains>, "schedule.mains", "--mains",
             "Hz of the supply of lamps; long exposures become whole half periods", {"off", "50", "60"}),
  };
}

std::vector<SettingField> sync_fields() {
  using S = Settings::Sync;
  return {
      any(kSync<&S::line>, "sync.line", "--sync-line", "line of the strobe: gpiochip0:17, or its name",
          "none"),
      choice(kSync<&S::strobe>, "sync.strobe", "--strobe",
             "what a pulse of the strobe does: mark the frame, or span the exposure", {"frame", "exposure"}),
      any(kSync<&S::strobe_delay>, "sync.strobe_delay", "--strobe-delay",
          "from the driver's timestamp to the rising edge, such as 250us"),
      any(kSync<&S::active_low>, "sync.active_low", "--sync-active-low", "a pulse is a low level"),
  };
}

std::vector<SettingField> fit_fields() {
  using F = Settings::Fit;
  return {
      choice(kFit<&F::preset>, "fit.preset", "--preset", "quality against time",
             {"fast", "balanced", "best"}),
      choice(kFit<&F::emit>, "fit.emit", "--emit", "layers of the HDR frames: all, or one alone",
             {"merged", "state", "field"}),
      number(kFit<&F::lookahead>, "fit.lookahead", "--lookahead", "later frames that an HDR frame waits for",
             {0, 2, {}}),
      number(kFit<&F::threads>, "fit.threads", "--threads", "worker threads", {1, 256, 0}, "all processors"),
      number(kFit<&F::seed>, "fit.seed", "--seed", "seed of the fit's random rays", {0, kMostInt, {}}),
      number(kFit<&F::code_noise>, "fit.code_noise", "--code-noise",
             "rms of compression noise, codes: 1 clean, 2 MJPEG", {0, 20, {}}),
  };
}

std::vector<SettingField> output_fields() {
  using O = Settings::Output;
  return {
      any(kOutput<&O::frames>, "output.frames", "-o,--output",
          "HDR frames, numbered by the sensor's sequence: out/%06d.exr", "none"),
      list(kOutput<&O::layers>, "output.layers", "--layers",
           "further EXR channels: depth,flow,confidence,provenance", "none"),
      choice(kOutput<&O::compression>, "output.compression", "--compression", "compression of the EXR files",
             {"zip", "piz"}),
      any(kOutput<&O::preview>, "output.preview", "--preview", "tone-mapped pictures: out/%06d.png", "none"),
      any(kOutput<&O::sheet>, "output.sheet", "--sheet", "contact sheet of the run: sheet.png", "none"),
      any(kOutput<&O::stats>, "output.stats", "--stats", "time, losses and provenance per frame: stats.json",
          "none"),
      any(kOutput<&O::report>, "output.report", "--report", "all of that on one page: report.html", "none"),
  };
}

std::vector<SettingField> record_fields() {
  using R = Settings::Record;
  return {
      any(kRecord<&R::file>, "record.file", "--record", "the raw recording to write: walk.mkv", "none"),
      number(kRecord<&R::memory_mib>, "record.memory_mib", "--record-memory",
             "MiB of frames that may wait for the disk", {1, 65536, {}}),
  };
}

std::vector<SettingField> all_fields() {
  const std::pair<SettingGroup, std::vector<SettingField>> groups[] = {
      {SettingGroup::Camera, camera_fields()}, {SettingGroup::Schedule, schedule_fields()},
      {SettingGroup::Sync, sync_fields()},     {SettingGroup::Fit, fit_fields()},
      {SettingGroup::Output, output_fields()}, {SettingGroup::Record, record_fields()},
  };
  std::vector<SettingField> all;
  for (const auto& [group, fields] : groups)
    for (SettingField field : fields) {
      field.group = group;
      all.push_back(std::move(field));
    }
  return all;
}

template <class T>
bool holds(const SettingField& field) {
  return std::holds_alternative<SettingPlace<T>>(field.place);
}

bool is_number(const SettingField& field) { return holds<int>(field) || holds<double>(field); }

bool in_range(const SettingRange& range, double value) {
  return (value >= range.least && value <= range.most) || (range.besides && value == *range.besides);
}

std::string either(const std::vector<std::string>& choices) {
  const auto last = choices.end() - 1;
  return fmt::format("{} or {}", fmt::join(choices.begin(), last, ", "), *last);
}

std::string shown(const SettingValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text ? fmt::format("'{}'", *text) : to_text(value);
}

template <class T>
std::optional<T> parsed_number(const std::string& text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  return failure == std::errc{} && stop == end ? std::optional(value) : std::nullopt;
}

// The value of the field's own type that the given one stands for.
std::optional<SettingValue> converted(const SettingField& field, const SettingValue& value) {
  const bool text_of_number = field.list || !field.choices.empty();
  if (holds<std::string>(field) && text_of_number && !std::holds_alternative<bool>(value))
    return to_text(value);
  if (holds<double>(field) && std::holds_alternative<int>(value))
    return static_cast<double>(std::get<int>(value));
  const auto* real = std::get_if<double>(&value);
  if (holds<int>(field) && real && std::abs(*real) <= kMostInt && *real == std::trunc(*real))
    return static_cast<int>(*real);
  if (value.index() != field.place.index()) return std::nullopt;
  return value;
}

bool allowed(const SettingField& field, const SettingValue& value) {
  if (const auto* text = std::get_if<std::string>(&value))
    return field.choices.empty() || std::ranges::find(field.choices, *text) != field.choices.end();
  if (const auto* whole = std::get_if<int>(&value)) return in_range(field.range, *whole);
  if (const auto* real = std::get_if<double>(&value)) return in_range(field.range, *real);
  return true;
}

}  // namespace

std::span<const SettingField> setting_fields() {
  static const std::vector<SettingField> fields = all_fields();
  return fields;
}

const char* title(SettingGroup group) {
  switch (group) {
    case SettingGroup::Camera:
      return "Camera";
    case SettingGroup::Schedule:
      return "Schedule";
    case SettingGroup::Sync:
      return "Sync line";
    case SettingGroup::Fit:
      return "Fit";
    case SettingGroup::Output:
      return "Output";
    case SettingGroup::Record:
      return "Recording";
  }
  return "";
}

const char* flag_of(const SettingField& field, std::span<const SettingGroup> groups) {
  const bool frames_go_out = std::ranges::find(groups, SettingGroup::Output) != groups.end();
  return std::string_view(field.key) == "record.file" && !frames_go_out ? "-o,--output" : field.flag;
}

std::string describe(const SettingField& field) {
  std::vector<std::string> notes;
  if (!field.choices.empty()) notes.push_back(either(field.choices));
  if (is_number(field) && field.range.most < kMostInt)
    notes.push_back(fmt::format("{}..{}", field.range.least, field.range.most));
  if (*field.unset != '\0')
    notes.push_back(
        fmt::format("{}: {}", is_number(field) ? to_text(*field.range.besides) : "\"\"", field.unset));
  return notes.empty() ? field.about : fmt::format("{} ({})", field.about, fmt::join(notes, "; "));
}

std::string accepted(const SettingField& field) {
  if (!field.choices.empty()) return either(field.choices);
  if (holds<bool>(field)) return "true or false";
  if (!is_number(field)) return field.list ? "a text or a list" : "a text";
  const std::string range = fmt::format("{}, {}..{}", holds<int>(field) ? "a whole number" : "a number",
                                        field.range.least, field.range.most);
  return field.range.besides ? fmt::format("{} or {}", range, *field.range.besides) : range;
}

SettingValue value_of(const SettingField& field, const Settings& settings) {
  return std::visit([&](const auto& place) -> SettingValue { return place.of(settings); }, field.place);
}

std::string to_text(const SettingValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

Error not_accepted(const SettingField& field, std::string_view name, std::string_view shown) {
  return {ErrorCode::Invalid, fmt::format("{} takes {}, not {}", name, accepted(field), shown)};
}

Result<void> set(const SettingField& field, const SettingValue& given, std::string_view name,
                 Settings& settings) {
  const auto value = converted(field, given);
  if (!value || !allowed(field, *value))
    return not_accepted(field, name, shown(given) + did_you_mean(to_text(given), field.choices));
  std::visit([&]<class T>(const SettingPlace<T>& place) { place.in(settings) = std::get<T>(*value); },
             field.place);
  return {};
}

Result<void> set_from_text(const SettingField& field, const std::string& text, std::string_view name,
                           Settings& settings) {
  std::optional<SettingValue> value;
  if (holds<std::string>(field)) value = text;
  if (holds<bool>(field) && (text == "true" || text == "false")) value = text == "true";
  if (holds<int>(field)) value = parsed_number<int>(text);
  if (holds<double>(field)) value = parsed_number<double>(text);
  return set(field, value.value_or(text), name, settings);
}

}  // namespace hdrcam
