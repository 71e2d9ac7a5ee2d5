#include "firmware_host/pipeline.h"

#include <chrono>

namespace hdrcam {
namespace {

struct NamedPreset {
  Preset preset;
  const char* name;
};
constexpr NamedPreset kPresets[] = {{Preset::Fast, "fast"}, {Preset::Balanced, "balanced"}, {Preset::Best, "best"}};

std::optional<Response> known_response(const CameraFacts& camera) {
  if (camera.linear) return Response::linear();
  if (camera.response.size() != 3) return std::nullopt;
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (camera.response[c].size() != Response::kCodes) return std::nullopt;
    for (std::size_t z = 0; z < Response::kCodes; ++z) inverse[c][z] = static_cast<float>(camera.response[c][z]);
  }
  return Response(inverse);
}

void add_to(std::vector<NamedValue>& values, const char* stage, double ms) {
  for (NamedValue& value : values)
    if (value.name == stage) {
      value.value += ms;
      return;
    }
  values.push_back({stage, ms});
}

}  // namespace

Result<Preset> parse_preset(std::string_view text) {
  for (const NamedPreset& known : kPresets)
    if (text == known.name) return known.preset;
  return Error{ErrorCode::Invalid, fmt::format("there is no preset '{}'; take fast, balanced or best", text)};
}

const char* name(Preset preset) {
  for (const NamedPreset& known : kPresets)
    if (preset == known.preset) return known.name;
  return "?";
}

PipelineOptions options_of(Preset preset) {
  PipelineOptions options;
  switch (preset) {
    case Preset::Fast: options.online.flow = FlowQuality::Fast; break;
    case Preset::Balanced: break;
    case Preset::Best: options.online.flow = FlowQuality::Fine; break;
  }
  return options;
}

Result<std::unique_ptr<Pipeline>> Pipeline::create(const PipelineOptions& options, const CameraFacts& camera,
                                                   WorkerPool& pool) {
  if (camera.layout != PixelLayout::Rgb && camera.layout != PixelLayout::Mono)
    return Error{ErrorCode::Unsupported,
                 fmt::format("frames of layout {} cannot be fitted yet; record RGB, or convert them", name(camera.layout))};
  const std::optional<Response> response = known_response(camera);
  return std::unique_ptr<Pipeline>(new Pipeline(options, camera, response ? &*response : nullptr, pool));
}

Pipeline::Pipeline(const PipelineOptions& options, const CameraFacts& camera, const Response* response,
                   WorkerPool& pool)
    : camera_(camera),
      online_(options.online, camera.height, camera.width, camera.bits, response, pool),
      emission_(options.emission, pool) {
  online_.set_timing([this](const char* stage, double ms) { add_to(record_.stages_ms, stage, ms); });
}

Result<void> Pipeline::take(const RawFrame& raw, const Deliver& deliver) {
  if (raw.codes.rows() != camera_.height || raw.codes.cols() != camera_.width)
    return Error{ErrorCode::SizeChanged,
                 fmt::format("frame {} is {}x{}, the clip is {}x{}; split the clip where its size changes",
                             raw.facts.sequence, raw.codes.cols(), raw.codes.rows(), camera_.width, camera_.height)};
  if (!first_time_) first_time_ = raw.facts.timestamp;
  return online_.ingest(raw, [&](const Moment& moment) { return render(moment, deliver); });
}

Result<void> Pipeline::finish(const Deliver& deliver) {
  return online_.finish([&](const Moment& moment) { return render(moment, deliver); });
}

Result<void> Pipeline::render(const Moment& moment, const Deliver& deliver) {
  const auto start = std::chrono::steady_clock::now();
  emission_.render(moment, frame_);
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
  add_to(record_.stages_ms, "emission", spent.count());

  record_.sequence = frame_.facts.sequence;
  record_.time_s = to_seconds(frame_.facts.timestamp - *first_time_);
  record_.exposure = static_cast<double>(frame_.exposure);
  record_.total_ms = 0;
  for (const NamedValue& stage : record_.stages_ms) record_.total_ms += stage.value;
  std::array<double, kProvenances> pixels{};
  for (const std::uint8_t from : frame_.provenance.samples()) pixels[from] += 1;
  for (std::size_t i = 0; i < kProvenances; ++i)
    record_.provenance_share[i] = static_cast<float>(pixels[i] / static_cast<double>(frame_.provenance.size()));
  auto delivered = deliver(frame_, *moment.frame, record_);
  record_ = {};
  return delivered;
}

}  // namespace hdrcam
