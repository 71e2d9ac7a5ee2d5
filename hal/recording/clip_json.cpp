#include "hal/recording/clip_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/core/counted.h"
#include "hal/core/json_text.h"
#include "hal/core/sound_facts.h"
#include "hal/core/split_text.h"
#include "hal/recording/exposure_cycle.h"
#include "hal/recording/facts_json.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

// Python writes NaN and Infinity, which JSON does not have. They become strings of the same length, so that
// positions stay and the field is refused because it is not a number. The mark tells them from other strings.
constexpr std::array<std::string_view, 3> kNonNumbers = {"-Infinity", "Infinity", "NaN"};
constexpr char kNonNumberMark = '\x7f';

void quote_non_numbers(std::string& text) {
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') in_string = !in_string;
    if (text[i] == '\\' && in_string) ++i;
    if (in_string) continue;
    for (const std::string_view word : kNonNumbers)
      if (text.compare(i, word.size(), word) == 0) {
        text[i] = text[i + word.size() - 1] = '"';
        text[i + 1] = kNonNumberMark;
        i += word.size() - 1;
        break;
      }
  }
}

// The word that became this string; "" for any other value.
std::string_view non_number(const Json& value) {
  if (!value.is_string()) return "";
  const auto& text = value.get_ref<const std::string&>();
  if (!text.starts_with(kNonNumberMark)) return "";
  const auto* const word = std::ranges::find(kNonNumbers, text.size() + 2, &std::string_view::size);
  return word == kNonNumbers.end() ? "" : *word;
}

// The value, shortened, for a message.
std::string shown_value(const Json& value) {
  constexpr std::size_t kMostBytes = 40;
  if (const std::string_view word = non_number(value); !word.empty()) return std::string(word);
  std::string text = json_text(value);
  if (text.size() <= kMostBytes) return text;
  return fmt::format("{}..", first_characters(text, kMostBytes));
}

Result<Json> parsed(std::string& text, const std::string& path) {
  if (nests_too_deep(text))
    return Error{ErrorCode::Invalid, fmt::format("'{}' has more than {} arrays and objects in each other; a "
                                                 "clip.json needs four",
                                                 path, kDeepestJson)};
  quote_non_numbers(text);
  try {
    Json json = Json::parse(text);
    if (const auto key = repeated_key<Json>(text))
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}' names '{}' twice in one object; name it once", path, *key)};
    return json;
  } catch (const Json::parse_error& e) {
    const std::size_t byte = std::min(e.byte, text.size());
    const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    return Error{ErrorCode::Invalid, fmt::format("'{}' is not JSON at line {}, byte {}: {}", path, lines + 1,
                                                 byte, json_reason(e))};
  } catch (const Json::exception& e) {
    return Error{ErrorCode::Invalid, fmt::format("'{}' is not usable: {}", path, json_reason(e))};
  }
}

// The members of one JSON object. `where` begins every message.
class Fields {
 public:
  Fields(const Json& object, std::string where) : object_(object), where_(std::move(where)) {}

  const std::string& where() const { return where_; }
  bool has(const char* key) const { return object_.is_object() && object_.contains(key); }
  // What the field is, for a message.
  std::string shown(const char* key) const {
    return has(key) ? "is " + shown_value(object_.at(key)) : "is missing";
  }
  Error wrong(const char* key, std::string_view expected, ErrorCode code = ErrorCode::Invalid) const {
    return {code, fmt::format("{}: '{}' {}; {}", where_, key, shown(key), expected)};
  }

  Result<double> number(const char* key, std::optional<double> otherwise = std::nullopt) const {
    if (!has(key) && otherwise) return *otherwise;
    if (!has(key) || !object_.at(key).is_number()) return wrong(key, "a number is needed");
    return object_.at(key).get<double>();
  }
  template <class T>
  Result<T> integer(const char* key, std::optional<T> otherwise = std::nullopt) const {
    if (!has(key) && otherwise) return *otherwise;
    if (!has(key) || !object_.at(key).is_number_integer()) return wrong(key, "a whole number is needed");
    if (const auto number = whole_number<T>(object_.at(key))) return *number;
    return wrong(key, "it is out of range");
  }
  // A factor of the exposure: positive and finite; 0 where the frame says that it is unknown.
  Result<double> exposure_factor(const char* key, ExposureSource source,
                                 std::optional<double> otherwise = std::nullopt) const {
    if (!has(key) && otherwise) return *otherwise;
    const bool is_number = has(key) && object_.at(key).is_number();
    const double value = is_number ? object_.at(key).get<double>() : 0;
    if (is_number && value == 0 && source == ExposureSource::Unknown) return value;
    if (!(value > 0) || !std::isfinite(value))
      return wrong(key, "the exposure of a frame must be known, positive and finite", ErrorCode::BadExposure);
    return value;
  }
  Result<std::string> text(const char* key) const {
    if (!has(key) || !object_.at(key).is_string() || object_.at(key).get_ref<const std::string&>().empty())
      return wrong(key, "a text is needed");
    return object_.at(key).get<std::string>();
  }
  // An array of so many numbers.
  Result<std::vector<double>> numbers(const char* key, std::size_t count) const {
    const auto is_number = [](const Json& value) { return value.is_number(); };
    if (!has(key) || !object_.at(key).is_array() || object_.at(key).size() != count ||
        !std::all_of(object_.at(key).begin(), object_.at(key).end(), is_number))
      return Error{ErrorCode::Invalid, fmt::format("{}: '{}' must be {} numbers", where_, key, count)};
    return object_.at(key).get<std::vector<double>>();
  }
  const Json& at(const char* key) const { return object_.at(key); }

 private:
  const Json& object_;
  std::string where_;
};

Result<std::vector<std::vector<double>>> response_of(const Fields& clip) {
  const Json& rows = clip.at("response");
  const auto is_curve = [](const Json& row) { return row.is_array() && row.size() == 256; };
  if (!rows.is_array() || rows.size() != 3 || !std::all_of(rows.begin(), rows.end(), is_curve))
    return Error{ErrorCode::Invalid,
                 fmt::format("{}: 'response' must be three rows of 256 numbers", clip.where())};
  constexpr const char* kChannels[] = {"red", "green", "blue"};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t code = 0; code < rows[c].size(); ++code)
      if (const Json& value = rows[c][code]; !value.is_number())
        return Error{ErrorCode::Invalid,
                     fmt::format("{}: the response of {} is {} at code {}; a number is needed", clip.where(),
                                 kChannels[c], shown_value(value), code)};
  return rows.get<std::vector<std::vector<double>>>();
}

Result<CameraFacts> camera_of(const Fields& clip) {
  CameraFacts camera;
  if (clip.has("name")) camera.name = clip.at("name").is_string() ? clip.at("name").get<std::string>() : "";
  camera.width = TRY(clip.integer<int>("width"));
  camera.height = TRY(clip.integer<int>("height"));
  camera.framerate_hz = TRY(clip.number("fps"));
  camera.bits = TRY(clip.integer<int>("bits"));
  for (const auto& [key, side_px] : {std::pair{"width", camera.width}, std::pair{"height", camera.height}})
    if (!is_possible_side(side_px))
      return clip.wrong(key, fmt::format("{} to {} pixels are possible", kMinSidePx, kMaxSidePx));
  if (!(camera.framerate_hz > 0)) return clip.wrong("fps", "it must be greater than 0");
  if (camera.bits < 8 || camera.bits > 16) return clip.wrong("bits", "8 to 16 are possible");
  if (clip.has("layout")) {
    const auto layout = layout_named(TRY(clip.text("layout")));
    if (!layout) return clip.wrong("layout", "it is one of rgb, mono, rggb, grbg, gbrg, bggr");
    camera.layout = *layout;
  }
  for (const auto& [key, fact] :
       {std::pair{"linear", &camera.linear}, std::pair{"turned_upright", &camera.turned_upright}})
    if (clip.has(key)) {
      if (!clip.at(key).is_boolean()) return clip.wrong(key, "it is true or false");
      *fact = clip.at(key).get<bool>();
    }
  constexpr const char* kLens[] = {"fx", "fy", "cx", "cy"};
  if (std::ranges::any_of(kLens, [&clip](const char* key) { return clip.has(key); }))
    camera.intrinsics = Intrinsics{TRY(clip.number("fx")), TRY(clip.number("fy")), TRY(clip.number("cx")),
                                   TRY(clip.number("cy"))};
  if (clip.has("white_balance")) {
    const auto gains = TRY(clip.numbers("white_balance", 3));
    std::copy(gains.begin(), gains.end(), camera.white_balance.emplace().begin());
  }
  if (clip.has("response")) camera.response = TRY(response_of(clip));
  if (const auto objection = objection_to(camera))
    return Error{ErrorCode::Invalid, fmt::format("{}: {}", clip.where(), *objection)};
  return camera;
}

Result<void> take_exposure(const Fields& fields, FrameFacts& facts) {
  if (fields.has("exposure_source")) {
    const auto source = exposure_source_named(TRY(fields.text("exposure_source")));
    if (!source)
      return fields.wrong(
          "exposure_source",
          "it is one of embedded, reported, declared, predicted, photometric, estimated, unknown");
    facts.exposure_source = *source;
  }
  facts.exposure_s = TRY(fields.exposure_factor("exposure_s", facts.exposure_source));
  facts.analogue_gain = TRY(fields.exposure_factor("gain", facts.exposure_source, 1));
  facts.digital_gain = TRY(fields.exposure_factor("digital_gain", facts.exposure_source, 1));
  return {};
}

// Of the centre of the exposure; in nanoseconds where seconds do not hold it exactly.
Result<Instant> timestamp_of(const Fields& fields) {
  const double time_s = TRY(fields.number("time_s"));
  if (!(std::abs(time_s) < kLatest_s))
    return fields.wrong("time_s", "it is the centre of the exposure in seconds");
  if (fields.has("timestamp_ns"))
    return Instant{Duration(TRY(fields.integer<Duration::rep>("timestamp_ns")))};
  return Instant::from_seconds(time_s);
}

// before: the frame before it, or null.
Result<ClipFrame> frame_of(const Json& json, std::size_t index, const std::string& path, int bits,
                           const ClipFrame* before) {
  ClipFrame frame;
  const Fields unnamed(json, fmt::format("'{}': frame {}", path, index));
  frame.file = TRY(unnamed.text("file"));
  if (frame.file.find('\0') != std::string::npos)
    return unnamed.wrong("file", "no file has a name with a NUL in it");
  const Fields fields(json, fmt::format("'{}': frame {} ('{}')", path, index, frame.file));
  FrameFacts& facts = frame.facts;
  TRY(take_exposure(fields, facts));
  facts.timestamp = TRY(timestamp_of(fields));
  facts.sequence = TRY(fields.integer<std::uint64_t>("sequence", index));
  if (fields.has("readout_s")) facts.readout_s = TRY(fields.number("readout_s"));
  facts.slot = TRY(fields.integer<int>("slot", -1));
  if (fields.has("black_level"))
    facts.black_level = BlackLevel::of_code(TRY(fields.number("black_level")), bits);
  facts.flags = TRY(fields.integer<std::uint32_t>("flags", 0));
  if (fields.has("verdict")) {
    facts.verdict = verdict_named(TRY(fields.text("verdict")));
    if (!facts.verdict)
      return fields.wrong("verdict", "it is one of proved, plausible, estimated, contradicted, unknown");
  }
  if (fields.has("exposure_within_ev")) facts.exposure_within_ev = TRY(fields.number("exposure_within_ev"));
  if (fields.has("c2w")) {
    const auto pose = TRY(fields.numbers("c2w", 12));
    std::copy(pose.begin(), pose.end(), facts.T_world_camera.emplace().begin());
  }
  if (const auto objection = objection_to(facts, before != nullptr ? &before->facts : nullptr))
    return Error{ErrorCode::Invalid, fmt::format("{}: {}", fields.where(), *objection)};
  return frame;
}

// The slot of each frame as it follows from the exposures alone.
std::vector<int> slots_of(const std::vector<ClipFrame>& frames) {
  const auto unstated = [](FrameFacts facts) { return facts.slot = -1, facts; };
  ExposureCycleSearch search;
  for (const ClipFrame& frame : frames) search.add(unstated(frame.facts));
  const ExposureCycle cycle = search.cycle();
  std::vector<int> slots;
  slots.reserve(frames.size());
  for (const ClipFrame& frame : frames) slots.push_back(slot_of(cycle, frames.front().facts, frame.facts));
  return slots;
}

Json frame_json(const ClipFrame& frame, std::size_t index, bool with_slot, int bits) {
  const FrameFacts& facts = frame.facts;
  const FrameFacts usual;
  const double time_s = static_cast<double>(facts.timestamp.since_boot.count()) / 1e9;
  Json json = {{"file", frame.file}, {"time_s", time_s}, {"exposure_s", facts.exposure_s}};
  const bool time_fits = std::abs(time_s) < kLatest_s && Instant::from_seconds(time_s) == facts.timestamp;
  if (!time_fits) json["timestamp_ns"] = facts.timestamp.since_boot.count();
  if (facts.analogue_gain != usual.analogue_gain) json["gain"] = facts.analogue_gain;
  if (facts.digital_gain != usual.digital_gain) json["digital_gain"] = facts.digital_gain;
  if (facts.sequence != index) json["sequence"] = facts.sequence;
  if (facts.readout_s > 0) json["readout_s"] = facts.readout_s;
  if (with_slot) json["slot"] = facts.slot;
  if (facts.black_level) json["black_level"] = facts.black_level->code(bits);
  if (facts.exposure_source != usual.exposure_source) json["exposure_source"] = name(facts.exposure_source);
  if (facts.verdict) json["verdict"] = name(*facts.verdict);
  if (facts.exposure_within_ev) json["exposure_within_ev"] = *facts.exposure_within_ev;
  if (facts.flags != usual.flags) json["flags"] = facts.flags;
  if (facts.T_world_camera) json["c2w"] = *facts.T_world_camera;
  return json;
}

}  // namespace

Result<Clip> clip_from_json(std::string text, const std::string& path) {
  const Json json = TRY(parsed(text, path));
  const Fields fields(json, fmt::format("'{}'", path));
  if (!json.is_object()) return Error{ErrorCode::Invalid, fmt::format("'{}' holds no JSON object", path)};
  Clip clip;
  clip.camera = TRY(camera_of(fields));
  clip.layout_is_named = fields.has("layout");
  if (!fields.has("frames") || !fields.at("frames").is_array())
    return fields.wrong("frames", "a list of frames is needed");
  const Json& frames = fields.at("frames");
  if (frames.size() < kFewestClipFrames)
    return Error{ErrorCode::TooShort,
                 fmt::format("'{}' has {}; at least two are needed", path, counted(frames.size(), "frame"))};
  bool slots_are_named = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const ClipFrame* before = clip.frames.empty() ? nullptr : &clip.frames.back();
    clip.frames.push_back(TRY(frame_of(frames[i], i, path, clip.camera.bits, before)));
    slots_are_named = slots_are_named || frames[i].contains("slot");
  }
  if (slots_are_named) return clip;
  const auto slots = slots_of(clip.frames);
  for (std::size_t i = 0; i < slots.size(); ++i) clip.frames[i].facts.slot = slots[i];
  return clip;
}

std::string clip_to_json(const Clip& clip) {
  const CameraFacts& camera = clip.camera;
  Json head = {{"name", camera.name},
               {"width", camera.width},
               {"height", camera.height},
               {"fps", camera.framerate_hz},
               {"bits", camera.bits}};
  if (const auto& lens = camera.intrinsics)
    head.update({{"fx", lens->fx_px}, {"fy", lens->fy_px}, {"cx", lens->cx_px}, {"cy", lens->cy_px}});
  if (is_bayer(camera.layout)) head["layout"] = name(camera.layout);
  if (camera.linear) head["linear"] = true;
  if (!camera.response.empty()) head["response"] = camera.response;
  if (camera.white_balance) head["white_balance"] = *camera.white_balance;
  if (camera.turned_upright) head["turned_upright"] = true;

  const auto told = slots_of(clip.frames);
  bool with_slots = false;
  for (std::size_t i = 0; i < told.size(); ++i)
    with_slots = with_slots || told[i] != clip.frames[i].facts.slot;

  const auto dumped = [](const Json& json) { return json_text(json); };
  std::string text = dumped(head);
  text.back() = ',';
  text += "\n\"frames\":[";
  for (std::size_t i = 0; i < clip.frames.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") + dumped(frame_json(clip.frames[i], i, with_slots, camera.bits));
  return text + "\n]}\n";
}

}  // namespace hdrcam
