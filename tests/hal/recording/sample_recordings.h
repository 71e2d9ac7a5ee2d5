// Recordings with known content for the tests: random pictures and facts that use every bit of every field.
#pragma once

#include <bit>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "hal/recording/recording.h"
#include "tests/support/scratch_folder.h"

namespace hdrcam::sample {

using test::scratch_folder;

// Files in the folder that never got their final name.
inline int unfinished_files_in(const std::string& folder) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    found += entry.path().extension() == ".part" ? 1 : 0;
  return found;
}

inline CameraFacts camera(PixelLayout layout, int bits, int width, int height) {
  CameraFacts camera;
  camera.name = "bridge \"é\"";
  camera.width = width, camera.height = height;
  camera.bits = bits;
  camera.layout = layout;
  camera.framerate_hz = 30000.0 / 1001.0;
  return camera;
}

inline Image<std::uint16_t> picture(const CameraFacts& camera, std::mt19937& random) {
  Image<std::uint16_t> codes(channels(camera.layout), camera.height, camera.width);
  const auto mask = static_cast<std::uint32_t>((1 << camera.bits) - 1);
  for (auto& code : codes.samples()) code = static_cast<std::uint16_t>(random() & mask);
  codes.samples().front() = static_cast<std::uint16_t>(mask);
  return codes;
}

inline FrameFacts facts(int index, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(1e-3, 1);
  FrameFacts facts;
  facts.sequence = (std::uint64_t{1} << 60) + static_cast<std::uint64_t>(2 * index);
  facts.timestamp.since_boot = Duration(1'234'567'890'123'456'789 + index * 33'366'700);
  facts.exposure_s = unit(random) * 1e-3;
  facts.analogue_gain = 1 + unit(random);
  facts.digital_gain = 1 + unit(random);
  facts.slot = index % 3;
  facts.black_level = BlackLevel(std::round(16e6 * unit(random)) / 1e6);
  constexpr Verdict kTurns[] = {Verdict::Proved, Verdict::Contradicted, Verdict::Plausible,
                                Verdict::Unknown};  // as the flags below
  if (index % 8 < 4) facts.verdict = kTurns[index % 4];
  if (index % 4 == 0) facts.exposure_within_ev = unit(random);
  if (index % 5 == 1) facts.readout_s = 0.02 * unit(random);
  facts.exposure_source = kExposureSources[static_cast<std::size_t>(index) % std::size(kExposureSources)];
  facts.flags = static_cast<std::uint32_t>(index % 8);
  if (index % 2 == 1) {
    const double angle = unit(random), c = std::cos(angle), s = std::sin(angle);
    facts.T_world_camera = {c, 0, s, unit(random) - 0.5, 0, 1, 0, unit(random), -s, 0, c, unit(random)};
  }
  return facts;
}

inline std::vector<RawFrame> frames(const CameraFacts& camera, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<RawFrame> frames;
  for (int i = 0; i < count; ++i) {
    FrameFacts frame_facts = facts(i, random);
    frames.push_back({std::move(frame_facts), picture(camera, random)});
  }
  return frames;
}

// The error of a call that must fail; an ok result gives a code that no test expects.
template <class T>
Error error_of(const Result<T>& result) {
  return result.ok() ? Error{ErrorCode::Timeout, "no error"} : result.error();
}

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

// A file keeps it to a millionth of a code.
inline bool same_black_level(const std::optional<BlackLevel>& a, const std::optional<BlackLevel>& b) {
  return a.has_value() == b.has_value() && (!a || std::abs(a->code(16) - b->code(16)) < 1e-3);
}

inline bool same(const FrameFacts& a, const FrameFacts& b) {
  if (a.T_world_camera.has_value() != b.T_world_camera.has_value()) return false;
  for (std::size_t i = 0; a.T_world_camera && i < 12; ++i)
    if (!same_bits((*a.T_world_camera)[i], (*b.T_world_camera)[i])) return false;
  return a.sequence == b.sequence && a.timestamp == b.timestamp && same_bits(a.exposure_s, b.exposure_s) &&
         same_bits(a.analogue_gain, b.analogue_gain) && same_bits(a.digital_gain, b.digital_gain) &&
         a.slot == b.slot && same_black_level(a.black_level, b.black_level) && a.verdict == b.verdict &&
         a.exposure_within_ev == b.exposure_within_ev && a.readout_s == b.readout_s &&
         a.exposure_source == b.exposure_source && a.flags == b.flags;
}

inline bool same(const Image<std::uint16_t>& a, const Image<std::uint16_t>& b) {
  return a.same_shape(b) && std::equal(a.samples().begin(), a.samples().end(), b.samples().begin());
}

inline bool same(const RawFrame& a, const RawFrame& b) {
  return same(a.facts, b.facts) && same(a.codes, b.codes);
}

constexpr RecordingCodec kCodecs[] = {RecordingCodec::Huffyuv, RecordingCodec::Ffv1};

// Appends the frames and finishes; stops at the first error.
inline Result<void> record(Storage& storage, const std::string& path, const CameraFacts& camera,
                           const std::vector<RawFrame>& frames,
                           RecordingCodec codec = RecordingCodec::Huffyuv) {
  auto writer = TRY(create_recording(storage, path, camera, Creation::Replace, codec));
  for (const RawFrame& frame : frames) TRY(writer->append(frame));
  return writer->finish();
}

// Everything that a reader returns, and how it ended.
struct Replayed {
  std::vector<RawFrame> frames;
  std::optional<Error> error;  // of open or next; none at a proper end

  bool ended_with(ErrorCode code) const { return error && error->code == code; }
  // Whether the frames are the first ones of `whole`, each the right one.
  bool is_start_of(const std::vector<RawFrame>& whole) const {
    return frames.size() <= whole.size() &&
           std::equal(frames.begin(), frames.end(), whole.begin(),
                      [](const RawFrame& a, const RawFrame& b) { return same(a, b); });
  }
};

inline Replayed replay(Storage& storage, const std::string& path) {
  Replayed replayed;
  auto reader = open_recording(storage, path);
  if (!reader) replayed.error = reader.error();
  while (!replayed.error) {
    auto frame = reader.value()->next();
    if (!frame)
      replayed.error = frame.error();
    else if (frame.value())
      replayed.frames.push_back(std::move(**frame));
    else
      break;
  }
  return replayed;
}

}  // namespace hdrcam::sample
