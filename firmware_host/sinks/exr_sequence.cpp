#include "firmware_host/sinks/exr_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "firmware_host/sinks/frame_ledger.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/version.h"
#include "hal/core/parse_number.h"
#include "hal/core/sound_facts.h"

namespace hdrcam {
namespace {

constexpr const char* kSinceStart = "hdrcam.secondsSinceStart";
constexpr const char* kWhite = "hdrcam.white";

std::optional<double> number(const std::map<std::string, std::string>& texts, const char* name, double most) {
  const auto text = texts.find(name);
  if (text == texts.end()) return std::nullopt;
  const auto value = parse_number<double>(text->second);
  return value && is_within(*value, 0, most) ? value : std::nullopt;
}

// What the samples of each layer are, for whoever opens a file without our documentation.
void describe(const ExrLayers& layers, LengthUnit length_unit, std::map<std::string, std::string>& texts) {
  texts["hdrcam.unit.RGB"] = "scene-linear radiance; 1 saturates the reference exposure";
  if (layers.depth)
    texts["hdrcam.unit.Z"] = fmt::format("camera z, 0 where unknown; unit: {}", name(length_unit));
  if (layers.flow)
    texts["hdrcam.unit.backward"] = "pixels to the previous frame; u to the right, v down; 0 in the first";
  if (layers.flow_forward)
    texts["hdrcam.unit.forward"] = "pixels to the next frame; u to the right, v down; 0 in the last";
  if (layers.field_flow)
    texts["hdrcam.unit.field"] = "pixels to the previous frame, of the field; u to the right, v down";
  if (layers.field_flow_forward)
    texts["hdrcam.unit.field.forward"] = "pixels to the next frame, of the field; u to the right, v down";
  if (layers.confidence) {
    texts["hdrcam.unit.sigma"] =
        "standard deviation of ln(radiance + white / 5000), white what saturates the shortest exposure";
    texts["hdrcam.unit.confidence"] = "exp(-sigma), 0 to 1";
  }
  if (!layers.provenance) return;
  std::string& legend = texts["hdrcam.unit.provenance"];
  for (const ProvenanceLook& look : kProvenanceLooks)
    legend +=
        fmt::format("{}{} {}", legend.empty() ? "" : ", ", static_cast<int>(look.provenance), look.name);
}

void describe(const FramePose& pose, ExrAttributes& attributes) {
  attributes.T_world_camera = pose_matrix_of(pose.T_world_camera);
  attributes.texts["hdrcam.poseSource"] = name(pose.source);
  attributes.texts["hdrcam.lengthUnit"] = name(unit_of(pose.source));
  if (pose.world > 0) attributes.texts["hdrcam.poseWorld"] = fmt::format("{}", pose.world);
  if (pose.lost) attributes.texts["hdrcam.poseLost"] = "it only continues the motion before";
}

ExrAttributes attributes_of(const HdrFrame& frame, const ExrSequenceOptions& options, Instant start) {
  const FrameFacts& facts = frame.facts;
  ExrAttributes attributes;
  if (facts.has_exposure_time()) attributes.exposure_s = facts.exposure_s;
  attributes.framerate_hz = options.framerate_hz;
  attributes.white_cd_m2 = options.white_cd_m2;
  attributes.chromaticities = Chromaticities{};
  if (options.framerate_hz && facts.timestamp >= start)  // a clock that was set back has none
    attributes.time_code = time_code(facts.timestamp - start, *options.framerate_hz);
  if (frame.pose && frame.lens) describe(*frame.pose, attributes);  // two eyes have two
  attributes.owner = options.owner;
  describe(options.layers, frame.length_unit, attributes.texts);
  if (frame.white_balance)
    attributes.texts["hdrcam.whiteBalance"] = fmt::format("{:.6g}", fmt::join(*frame.white_balance, ", "));
  attributes.texts["hdrcam.gain"] = fmt::format("{:.6g}", facts.gain());
  attributes.texts["hdrcam.exposureSource"] = name(facts.exposure_source);
  if (facts.verdict) attributes.texts["hdrcam.exposureVerdict"] = name(*facts.verdict);
  if (facts.exposure_within_ev)
    attributes.texts["hdrcam.exposureWithinEv"] = fmt::format("{:.3f}", *facts.exposure_within_ev);
  attributes.texts[kSinceStart] = fmt::format("{:.9f}", to_seconds(facts.timestamp - start));
  if (frame.recorded_s) attributes.texts[kExrRecordedSeconds] = fmt::format("{:.9f}", *frame.recorded_s);
  attributes.texts[kWhite] = fmt::format("{}", frame.white);
  attributes.comments = fmt::format(
      "hdrcam {}; frame {}; radiance 1 saturates the reference exposure{}; this frame's exposure is "
      "{:.6g} times that",
      kVersion, facts.sequence,
      facts.has_exposure_time() ? fmt::format(" {:.6g} s at gain 1", frame.reference_exposure)
                                : ", which is estimated: no time is known",
      frame.exposure);
  return attributes;
}

// The planes of a frame that are not stored as samples of a file.
class DerivedPlanes {
 public:
  std::vector<ExrChannel> channels_of(const HdrFrame& frame, const ExrLayers& layers) {
    const std::size_t n = frame.radiance.plane_size();
    std::vector<ExrChannel> channels;
    const auto add = [&](std::string_view name, const Image<float>& image, int plane, ExrSample stored) {
      channels.push_back(
          {std::string(name), image.empty() ? zeros(n) : std::span(image.plane(plane), n), stored});
    };
    for (int c = 0; c < 3; ++c) add(exr_channel::kRadiance[c], frame.radiance, c, ExrSample::Half);
    if (layers.depth) add(exr_channel::kDepth, frame.depth, 0, ExrSample::Float);
    const auto add_flow = [&](bool wanted, const std::string_view(&names)[2], const Image<float>& flow) {
      for (int c = 0; wanted && c < 2; ++c) add(names[c], flow, c, ExrSample::Float);
    };
    add_flow(layers.flow, exr_channel::kFlowBackward, frame.flow);
    add_flow(layers.flow_forward, exr_channel::kFlowForward, frame.flow_forward);
    add_flow(layers.field_flow, exr_channel::kFieldFlow, frame.field_flow);
    add_flow(layers.field_flow_forward, exr_channel::kFieldFlowForward, frame.field_flow_forward);
    if (layers.confidence) {
      confidence_.resize(n);
      std::transform(frame.sigma.samples().begin(), frame.sigma.samples().end(), confidence_.begin(),
                     [](float sigma) { return std::exp(-sigma); });
      add(exr_channel::kSigma, frame.sigma, 0, ExrSample::Half);
      channels.push_back({"confidence", confidence_, ExrSample::Half});
    }
    if (layers.provenance) {
      provenance_.assign(frame.provenance.samples().begin(), frame.provenance.samples().end());
      channels.push_back({std::string(exr_channel::kProvenance), provenance_, ExrSample::Half});
    }
    return channels;
  }

 private:
  std::span<const float> zeros(std::size_t n) {
    zeros_.resize(n);
    return zeros_;
  }

  std::vector<float> zeros_, confidence_, provenance_;
};

Result<std::vector<std::byte>> encoded(const HdrFrame& frame, const ExrSequenceOptions& options,
                                       Instant start, DerivedPlanes& planes, std::vector<std::byte> room) {
  ExrPicture picture;
  picture.rows = frame.radiance.rows();
  picture.cols = frame.radiance.cols();
  picture.channels = planes.channels_of(frame, options.layers);
  picture.attributes = attributes_of(frame, options, start);
  picture.compression = options.compression;
  return encode_exr(picture, std::move(room));
}

class ExrSequence : public FrameSink {
 public:
  ExrSequence(Storage& storage, FramePattern pattern, FrameLedger ledger, ExrSequenceOptions options)
      : storage_(storage),
        pattern_(std::move(pattern)),
        ledger_(std::move(ledger)),
        options_(std::move(options)) {}

  Result<void> emit(const EmittedFrame& emitted) override {
    const HdrFrame& frame = emitted.hdr;
    if (!start_) start_ = frame.facts.timestamp;
    file_ = TRY(encoded(frame, options_, *start_, planes_, std::move(file_)));
    const std::string path = pattern_.path(frame.facts.sequence);
    TRY(write(path));
    return ledger_.append(frame.facts, emitted.record.time_s, path.substr(path.rfind('/') + 1));
  }

 private:
  Result<void> write(const std::string& path) {
    FileInMaking making = TRY(FileInMaking::beside_or_through(storage_, path));
    const auto file = TRY(making.create());
    TRY(file->write_at(0, file_));
    TRY(ledger_.take_name());
    return making.commit(Durability::WrittenBack);
  }

  Storage& storage_;
  const FramePattern pattern_;
  FrameLedger ledger_;
  const ExrSequenceOptions options_;
  std::optional<Instant> start_;
  DerivedPlanes planes_;  // of the frame being written
  std::vector<std::byte> file_;
};

}  // namespace

RunFacts run_facts_of(const ExrAttributes& attributes) {
  return {number(attributes.texts, kSinceStart, kLatest_s),
          number(attributes.texts, kWhite, std::numeric_limits<float>::max())};
}

Result<std::vector<std::byte>> encode_frame(const HdrFrame& frame, const ExrSequenceOptions& options,
                                            Instant start) {
  DerivedPlanes planes;
  return encoded(frame, options, start, planes, {});
}

Result<std::unique_ptr<FrameSink>> create_exr_sequence(Storage& storage, std::string_view pattern,
                                                       ExrSequenceOptions options) {
  auto parsed = TRY(FramePattern::parse("--output", pattern, ".exr"));
  TRY(storage.make_directories(parsed.folder()));
  FrameLedger ledger = TRY(FrameLedger::create(storage, parsed));
  return std::unique_ptr<FrameSink>(
      std::make_unique<ExrSequence>(storage, std::move(parsed), std::move(ledger), std::move(options)));
}

}  // namespace hdrcam
