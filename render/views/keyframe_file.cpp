#include "render/views/keyframe_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>

namespace hdrcam {
namespace {

constexpr std::string_view kSection = "frame";

// What every keyframe has, then what all but the first have.
template <class Key>
auto layers_of(Key& key) {
  return std::array{&key.frame.radiance, &key.frame.sigma, &key.inverse_depth};
}
template <class Key>
auto motion_of(Key& key) {
  return std::array{&key.to_previous.vectors, &key.to_previous.confidence, &key.from_previous.vectors,
                    &key.from_previous.confidence};
}
constexpr std::array kLayerChannels{3, 1, 1};
constexpr std::array kMotionChannels{2, 1, 2, 1};

// Of a pixel of these layers.
constexpr std::uint64_t bytes_of(std::span<const int> channels) {
  return sizeof(float) * static_cast<std::uint64_t>(std::accumulate(channels.begin(), channels.end(), 0));
}
constexpr std::uint64_t kPictureBytes = bytes_of(kLayerChannels) + sizeof(std::uint8_t);  // and provenance
constexpr std::uint64_t kMotionBytes = bytes_of(kMotionChannels);

bool all_within(std::span<const float> values, float least, float most) {
  return std::ranges::all_of(values, [=](float value) { return value >= least && value <= most; });
}

bool is_sound(const Keyframe& key) {
  constexpr float kMost = 1e30f, kFarthest_px = 1e6f;
  constexpr float kLeastInverse = 1e-30f, kMostInverse = 1e9f;  // of depth
  if (!all_within(key.frame.radiance.samples(), 0, kMost) || !all_within(key.frame.sigma.samples(), 0, kMost))
    return false;
  if (!all_within(key.inverse_depth.samples(), kLeastInverse, kMostInverse)) return false;
  for (const FlowField* flow : {&key.to_previous, &key.from_previous})
    if (!all_within(flow->vectors.samples(), -kFarthest_px, kFarthest_px) ||
        !all_within(flow->confidence.samples(), 0, 1))
      return false;
  return std::ranges::all_of(key.frame.provenance.samples(), [](auto p) { return p < kProvenances; });
}

}  // namespace

Result<void> save_pictures(const Keyframe& key, SectionWriter& file) {
  std::vector<Bytes> parts;
  for (const Image<float>* layer : layers_of(key)) parts.push_back(std::as_bytes(layer->samples()));
  parts.push_back(std::as_bytes(key.frame.provenance.samples()));
  if (!key.to_previous.empty())
    for (const Image<float>* layer : motion_of(key)) parts.push_back(std::as_bytes(layer->samples()));
  return file.add(kSection, parts);
}

Result<void> load_pictures(SectionReader& file, int rows, int cols, Keyframe& key) {
  TRY(file.begin(kSection));
  const std::uint64_t pixels = pixel_count(rows, cols);
  const bool has_motion = file.length() == pixels * (kPictureBytes + kMotionBytes);
  if (!has_motion && file.length() != pixels * kPictureBytes)
    return file.wrong("it is not as large as its pictures");
  const auto load = [&](Image<float>& layer, int channels) {
    layer.reshape(channels, rows, cols);
    return file.read(std::as_writable_bytes(layer.samples()));
  };
  for (std::size_t i = 0; i < kLayerChannels.size(); ++i) TRY(load(*layers_of(key)[i], kLayerChannels[i]));
  key.frame.provenance.reshape(1, rows, cols);
  TRY(file.read(std::as_writable_bytes(key.frame.provenance.samples())));
  if (has_motion)
    for (std::size_t i = 0; i < kMotionChannels.size(); ++i)
      TRY(load(*motion_of(key)[i], kMotionChannels[i]));
  TRY(file.end());
  const auto depths = key.inverse_depth.samples();
  key.knows_depth = std::ranges::adjacent_find(depths, std::ranges::not_equal_to()) != depths.end();
  return is_sound(key) ? Result<void>() : file.wrong("it holds a value that no picture has");
}

}  // namespace hdrcam
