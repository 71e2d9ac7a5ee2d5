// The scores that the emitted pictures must reach on small simulated clips: every number of the quality
// floor, in one place. A bound leaves room only for another machine's rounding: a change that improves the
// pictures raises it (`./run test "[floor]" -s -o FILE` writes the measured values), and from then on the
// suite requires it. Worse pictures fail.
#pragma once

#include "firmware_host/run/pipeline.h"

namespace hdrcam::test {

// Small clips, each difficult where a part of the method helps.
struct FloorClip {
  const char* scene;
  const char* shutter;
  int frames;
};
// hand-held, six objects that move, a sun that clips, shot noise, a film's response
inline constexpr FloorClip kWalk{"walk?size=128x96&seed=3&full-well=1500", "1ms,4ms,16ms", 20};
// its first frames: fits take their time
inline constexpr FloorClip kShortWalk{"walk?size=128x96&seed=3&full-well=1500", "1ms,4ms,16ms", 9};
// a quick pan; the longest exposure lasts as long as a frame
inline constexpr FloorClip kPan{"pan?size=112x84&seed=2&speed=2", "2ms,8ms,32ms", 16};
// few photons, quick things
inline constexpr FloorClip kDim{"fast?size=128x96&seed=2&full-well=500", "1.5ms,6ms,26ms", 16};

// Parts of the method, each with the setting that turns it off.
inline void leave(PipelineOptions&) {}
inline void no_look_ahead(PipelineOptions& options) { options.knobs.look_ahead = 0; }
inline void two_frames_ahead(PipelineOptions& options) { options.knobs.look_ahead = 2; }
inline void fill(PipelineOptions& options) { options.knobs.budget.fills = true; }
inline void no_shrinkage(PipelineOptions& options) { options.knobs.budget.shrinks = false; }
inline void no_warp_variance(PipelineOptions& options) { options.knobs.state.fusion.misalignment = 0; }
inline void no_blur_variance(PipelineOptions& options) {
  options.knobs.state.fusion.blur_variance = options.knobs.state.fusion.unknown_blur_variance = 0;
}
inline void no_gate(PipelineOptions& options) { options.knobs.state.fusion.chi2_tolerance = 1e9f; }
inline void assumed_noise(PipelineOptions& options) { options.knobs.noise = NoiseKind::Assumed; }
using Change = void (*)(PipelineOptions&);

struct PictureFloor {
  const char* name;
  FloorClip clip;
  Preset preset;
  EmitLayer layer;
  Change change;
  double psnr_mu_db, worst_db;        // at least
  double flicker_stops, phase_stops;  // at most
};
inline constexpr PictureFloor kPictureFloors[] = {
    {"state", kWalk, Preset::Balanced, EmitLayer::State, leave, 39.0, 37.1, 0.0711, 0.0065},
    {"state, look-ahead 0", kWalk, Preset::Balanced, EmitLayer::State, no_look_ahead, 37.75, 35.3, 0.0877,
     0.0095},
    {"state, look-ahead 2", kWalk, Preset::Balanced, EmitLayer::State, two_frames_ahead, 38.9, 36.6, 0.069,
     0.0065},
    {"state, quick pan", kPan, Preset::Balanced, EmitLayer::State, leave, 36.45, 33.7, 0.0473, 0.0035},
    {"state, few photons", kDim, Preset::Balanced, EmitLayer::State, leave, 31.7, 26.7, 0.117, 0.0065},
    {"merged, fast", kShortWalk, Preset::Fast, EmitLayer::Merged, leave, 38.65, 37.0, 0.0755, 0.0075},
    {"merged, balanced", kShortWalk, Preset::Balanced, EmitLayer::Merged, leave, 38.75, 37.1, 0.0743, 0.0085},
    {"merged, best", kShortWalk, Preset::Best, EmitLayer::Merged, leave, 38.75, 36.9, 0.0735, 0.008},
    {"field, fast", kShortWalk, Preset::Fast, EmitLayer::Field, leave, 36.5, 33.6, 0.0945, 0.015},
};

// Without the part the picture must lose this much; otherwise the part is useless or not active.
struct PartWorth {
  const char* part;
  FloorClip clip;
  Change without;
  double psnr_mu_db, flicker_stops;  // loses at least; negative where the part may cost a little of it
};
inline constexpr PartWorth kPartWorths[] = {
    {"look-ahead", kWalk, no_look_ahead, 1.0, 0.013},       {"shrinkage", kWalk, no_shrinkage, 0.6, 0.003},
    {"warp variance", kWalk, no_warp_variance, 2.9, 0.014}, {"gate", kWalk, no_gate, 0.17, -0.002},
    {"blur variance", kPan, no_blur_variance, 0.75, 0.005}, {"learned noise", kDim, assumed_noise, 1.2, 0.05},
};

// Balanced over fast, which has a coarser flow; best, which has the same, may not be worse than balanced.
inline constexpr double kFinerFlow_db = 0.01, kNotWorse_db = -0.05;

// The field's radiance of unseen pixels: at least so many samples on kShortWalk, and their error (mean
// |log2|) at most this share of the lower bound's that the state holds there.
inline constexpr int kFieldAnswers = 300;
inline constexpr double kFieldErrorShare = 1.05;
// The field alone is another picture than the state's: mean |log2| between them, stops.
inline constexpr double kFieldFromState_stops = 0.02;

// Squared error of ln radiance over the variance that the frame claims, before shrinkage; the median over
// pixels (.79 if errors were normal and the claim exact) and the ratio of the sums (1).
struct ClaimedVariance {
  Provenance provenance;
  double least_median, most_median, most_sum;
};
inline constexpr ClaimedVariance kClaimedVariances[] = {
    {Provenance::Own, 0.3, 1.4, 2},
    {Provenance::Carried, 0.3, 1.4, 2},
    {Provenance::LookAhead, 0.3, 1.4, 2},
};
// Of the pixels called a bound, those whose truth is not below nine tenths of it.
inline constexpr double kBoundsKept = 0.9;

}  // namespace hdrcam::test
