#include "hal/recording/facts_json.h"

#include <zlib.h>

#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "hal/core/json_text.h"

namespace hdrcam {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "hdrcam recording";
constexpr int kVersion = 2;  // the newest: pixels in Huffyuv; 1 has them in FFV1
constexpr std::string_view kSealKey = R"(,"crc32":")";
constexpr std::size_t kSealLength = 10 + 8 + 2;  // the key, eight hex digits, `"}`

// The library writes the shortest text that reads back as the same double, and null for a number that is not
// finite.
double number(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

template <class T>
T whole(const Json& value) {
  if (const auto number = whole_number<T>(value)) return *number;
  throw std::out_of_range(json_text(value) + " where a whole number within its range is needed");
}

Json parsed(std::string_view text) {
  if (nests_too_deep(text))
    throw std::out_of_range(fmt::format("more than {} arrays and objects in each other", kDeepestJson));
  return Json::parse(text);
}

std::uint32_t checksum(std::span<const std::uint8_t> payload, std::string_view text) {
  uLong crc = crc32_z(0, nullptr, 0);
  crc = crc32_z(crc, payload.data(), payload.size());
  crc = crc32_z(crc, reinterpret_cast<const Bytef*>(text.data()), text.size());
  return static_cast<std::uint32_t>(crc);
}

CameraFacts camera_of(const Json& json) {
  CameraFacts camera;
  camera.name = json.at("name").get<std::string>();
  camera.width = whole<int>(json.at("width"));
  camera.height = whole<int>(json.at("height"));
  camera.framerate_hz = number(json.at("framerate_hz"));
  camera.bits = whole<int>(json.at("bits"));
  camera.linear = json.at("linear").get<bool>();
  if (const auto lens = json.find("intrinsics"); lens != json.end())
    camera.intrinsics = Intrinsics{number(lens->at("fx_px")), number(lens->at("fy_px")),
                                   number(lens->at("cx_px")), number(lens->at("cy_px"))};
  if (const auto response = json.find("response"); response != json.end())
    for (const Json& row : *response) {
      auto& values = camera.response.emplace_back();
      for (const Json& value : row) values.push_back(number(value));
    }
  if (const auto gains = json.find("white_balance"); gains != json.end()) {
    auto& balance = camera.white_balance.emplace();
    for (std::size_t c = 0; c < balance.size(); ++c) balance[c] = number(gains->at(c));
  }
  if (const auto turned = json.find("turned_upright"); turned != json.end())
    camera.turned_upright = turned->get<bool>();
  return camera;
}

FrameFacts facts_of(const Json& json, int bits) {
  FrameFacts facts;
  facts.sequence = whole<std::uint64_t>(json.at("sequence"));
  facts.timestamp.since_boot = Duration(whole<Duration::rep>(json.at("timestamp_ns")));
  facts.exposure_s = number(json.at("exposure_s"));
  facts.analogue_gain = number(json.at("analogue_gain"));
  facts.digital_gain = number(json.at("digital_gain"));
  if (const auto readout = json.find("readout_s"); readout != json.end()) facts.readout_s = number(*readout);
  facts.slot = whole<int>(json.at("slot"));
  const double black = number(json.at("black_level"));
  if (black != 0 || json.contains("black_level_stated")) facts.black_level = BlackLevel::of_code(black, bits);
  if (const auto within = json.find("exposure_within_ev"); within != json.end())
    facts.exposure_within_ev = number(*within);
  facts.flags = whole<std::uint32_t>(json.at("flags"));
  if (const auto pose = json.find("T_world_camera"); pose != json.end()) {
    auto& T = facts.T_world_camera.emplace();
    for (std::size_t i = 0; i < T.size(); ++i) T[i] = number(pose->at(i));
  }
  return facts;
}

// read: takes values out of JSON, which throws where one is missing or of another kind. what: begins the
// message then.
template <class Read>
auto read_as(const char* what, const Read& read) -> decltype(read()) {
  try {
    return read();
  } catch (const Json::exception& e) {
    return Error{ErrorCode::Corrupt, fmt::format("{} cannot be read: {}", what, json_reason(e))};
  } catch (const std::exception& e) {
    return Error{ErrorCode::Corrupt, fmt::format("{} cannot be read: {}", what, e.what())};
  }
}

}  // namespace

std::string to_json(const CameraFacts& camera, RecordingCodec codec) {
  const int version = codec == RecordingCodec::Ffv1 ? 1 : kVersion;
  Json json = {{"format", kFormat},       {"version", version},
               {"name", camera.name},     {"width", camera.width},
               {"height", camera.height}, {"framerate_hz", camera.framerate_hz},
               {"bits", camera.bits},     {"layout", name(camera.layout)},
               {"linear", camera.linear}};
  if (const auto& lens = camera.intrinsics)
    json["intrinsics"] = {
        {"fx_px", lens->fx_px}, {"fy_px", lens->fy_px}, {"cx_px", lens->cx_px}, {"cy_px", lens->cy_px}};
  if (!camera.response.empty()) json["response"] = camera.response;
  if (camera.white_balance) json["white_balance"] = *camera.white_balance;
  if (camera.turned_upright) json["turned_upright"] = true;
  return json_text(json);
}

std::string to_json(std::uint64_t index, const FrameFacts& facts, int bits) {
  Json json = {{"index", index},
               {"sequence", facts.sequence},
               {"timestamp_ns", facts.timestamp.since_boot.count()},
               {"exposure_s", facts.exposure_s},
               {"analogue_gain", facts.analogue_gain},
               {"digital_gain", facts.digital_gain},
               {"slot", facts.slot},
               {"black_level", facts.black_level ? facts.black_level->code(bits) : 0},
               {"exposure_source", name(facts.exposure_source)},
               {"flags", facts.flags}};
  if (facts.black_level && json["black_level"] == 0) json["black_level_stated"] = true;
  if (facts.readout_s > 0) json["readout_s"] = facts.readout_s;
  if (facts.verdict) json["verdict"] = name(*facts.verdict);
  if (facts.exposure_within_ev) json["exposure_within_ev"] = *facts.exposure_within_ev;
  if (facts.T_world_camera) json["T_world_camera"] = *facts.T_world_camera;
  return json_text(json);
}

std::string end_record_json(std::uint64_t frames) {
  return json_text(Json{{"end", true}, {"frames", frames}});
}

Result<CameraFacts> camera_from_json(std::string_view text) {
  return read_as("the camera facts", [&]() -> Result<CameraFacts> {
    const Json json = parsed(text);
    if (json.at("format") != kFormat)
      return Error{ErrorCode::Corrupt, "the camera facts are of an unknown format"};
    if (const int version = whole<int>(json.at("version")); version > kVersion)
      return Error{ErrorCode::Unsupported,
                   fmt::format("the recording has format version {}, this program reads up to {}; update it",
                               version, kVersion)};
    CameraFacts camera = camera_of(json);
    const auto layout = layout_named(json.at("layout").get<std::string>());
    if (!layout) return Error{ErrorCode::Corrupt, "the camera facts name an unknown pixel layout"};
    camera.layout = *layout;
    return camera;
  });
}

Result<FactsRecord> record_from_json(std::string_view text, int bits) {
  return read_as("the facts of a frame", [&]() -> Result<FactsRecord> {
    const Json json = parsed(text);
    if (json.contains("end")) return FactsRecord{true, whole<std::uint64_t>(json.at("frames")), {}};
    FactsRecord record{false, whole<std::uint64_t>(json.at("index")), facts_of(json, bits)};
    const auto source = exposure_source_named(json.at("exposure_source").get<std::string>());
    if (!source) return Error{ErrorCode::Corrupt, "the facts of a frame name an unknown exposure source"};
    record.facts.exposure_source = *source;
    if (const auto found = json.find("verdict"); found != json.end()) {
      record.facts.verdict = verdict_named(found->get<std::string>());
      if (!record.facts.verdict)
        return Error{ErrorCode::Corrupt, "the facts of a frame name an unknown verdict on its exposure"};
    }
    return record;
  });
}

std::optional<PixelLayout> layout_named(std::string_view wanted) {
  for (const auto layout : {PixelLayout::Rgb, PixelLayout::Mono, PixelLayout::BayerRggb,
                            PixelLayout::BayerGrbg, PixelLayout::BayerGbrg, PixelLayout::BayerBggr})
    if (wanted == name(layout)) return layout;
  return std::nullopt;
}

std::optional<ExposureSource> exposure_source_named(std::string_view wanted) {
  for (const ExposureSource source : kExposureSources)
    if (wanted == name(source)) return source;
  return std::nullopt;
}

std::optional<Verdict> verdict_named(std::string_view wanted) {
  for (const Verdict verdict : kVerdicts)
    if (wanted == name(verdict)) return verdict;
  return std::nullopt;
}

std::string seal(const std::string& json_object, std::span<const std::uint8_t> payload) {
  HDRCAM_CHECK(json_object.size() > 2 && json_object.back() == '}');
  const std::string_view open(json_object.data(), json_object.size() - 1);
  return fmt::format("{}{}{:08x}\"}}", open, kSealKey, checksum(payload, open));
}

bool seal_holds(std::string_view sealed, std::span<const std::uint8_t> payload) {
  if (sealed.size() <= kSealLength) return false;
  const std::string_view open = sealed.substr(0, sealed.size() - kSealLength);
  return sealed.substr(open.size()) == fmt::format("{}{:08x}\"}}", kSealKey, checksum(payload, open));
}

}  // namespace hdrcam
