// The fields of a camera's facts, a frame's facts and a transform, for fields.h. Their order is that of the
// file: whoever adds one raises the version of every format that holds it. Reentrant.
#pragma once

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "hal/sections/fields.h"

namespace hdrcam {

template <Either<Intrinsics> Lens>
void list_fields(auto& fields, Lens& lens) {
  fields(lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px);
}

template <Either<RigidTransform> Transform>
void list_fields(auto& fields, Transform& T) {
  for (int row = 0; row < 3; ++row) fields(T.R(row, 0), T.R(row, 1), T.R(row, 2), T.t(row));
}

// Exact where every channel has the level that files state, the green one's.
template <Either<BlackLevel> Level>
void list_fields(auto& fields, Level& level) {
  std::array<float, 3> codes{level[0], level[1], level[2]};
  fields(codes);
  if constexpr (!std::is_const_v<Level>)
    for (std::size_t c = 0; c < codes.size(); ++c) level.set(c, codes[c]);
}

template <Either<Instant> Time>
void list_fields(auto& fields, Time& time) {
  std::int64_t ns = time.since_boot.count();
  fields(ns);
  if constexpr (!std::is_const_v<Time>) time.since_boot = Duration(ns);
}

template <Either<FrameFacts> Facts>
void list_fields(auto& fields, Facts& facts) {
  fields(facts.sequence, facts.timestamp, facts.exposure_s, facts.analogue_gain, facts.digital_gain,
         facts.readout_s, facts.slot, facts.black_level);
  fields.word(facts.exposure_source, ExposureSource::Unknown);
  bool judged = facts.verdict.has_value();
  Verdict verdict = facts.verdict.value_or(Verdict::Unknown);
  fields(judged);
  fields.word(verdict, Verdict::Unknown);
  if constexpr (!std::is_const_v<Facts>) facts.verdict = judged ? std::optional(verdict) : std::nullopt;
  fields(facts.exposure_within_ev, facts.flags, facts.T_world_camera);
}

// Without turned_upright: nothing that starts from a file of sections is corrected for a read-out.
template <Either<CameraFacts> Facts>
void list_fields(auto& fields, Facts& camera) {
  fields(camera.name, camera.width, camera.height, camera.framerate_hz, camera.bits);
  fields.word(camera.layout, PixelLayout::BayerBggr);
  fields(camera.linear, camera.intrinsics, camera.response, camera.white_balance);
}

}  // namespace hdrcam
