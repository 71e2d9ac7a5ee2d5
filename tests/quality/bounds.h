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
  const char* format = "rgb";
};
// hand-held, six objects that move, a sun that clips, shot noise, a film's response
inline constexpr FloorClip kWalk{"walk?size=128x96&seed=3&full-well=1500", "1ms,4ms,16ms", 20};
// its first frames: fits take their time
inline constexpr FloorClip kShortWalk{"walk?size=128x96&seed=3&full-well=1500", "1ms,4ms,16ms", 9};
// a quick pan; the longest exposure lasts as long as a frame
inline constexpr FloorClip kPan{"pan?size=112x84&seed=2&speed=2", "2ms,8ms,32ms", 16};
// few photons, quick things
inline constexpr FloorClip kDim{"fast?size=128x96&seed=2&full-well=500", "1.5ms,6ms,26ms", 16};

// raw codes of 12 bits behind a mosaic
inline constexpr FloorClip kRaw{"walk?size=128x96&seed=5", "1ms,4ms,16ms", 14, "bayer"};
// lamps on the mains, which short exposures catch brighter or darker
inline constexpr FloorClip kMains{"night?size=128x96&seed=15&full-well=20000&read-noise=3&without=flare",
                                  "1ms,4ms,16ms", 14, "bayer"};

// lamps on the mains that light frames of one exposure otherwise each time
inline constexpr FloorClip kLamps{"walk?size=128x96&seed=3&fps=24&with=mains-flicker", "1ms,2ms,4ms", 20};

// Parts of the method, each with the setting that turns it off.
inline void leave(PipelineOptions&) {}
inline void no_look_ahead(PipelineOptions& options) { options.knobs.look_ahead = 0; }
inline void one_frame_ahead(PipelineOptions& options) { options.knobs.look_ahead = 1; }
inline void fill(PipelineOptions& options) { options.knobs.budget.fills = true; }
inline void no_shrinkage(PipelineOptions& options) { options.knobs.budget.shrinkage = ShrinkageEffort::Off; }
inline void no_warp_variance(PipelineOptions& options) { options.knobs.state.fusion.misalignment = 0; }
inline void no_blur_variance(PipelineOptions& options) {
  options.knobs.state.fusion.blur_variance = options.knobs.state.fusion.unknown_blur_variance = 0;
}
inline void no_gate(PipelineOptions& options) { options.knobs.state.fusion.chi2_tolerance = 1e9f; }
inline void no_rolling_shutter(PipelineOptions& options) { options.render.readout_s = 0; }
inline void assumed_noise(PipelineOptions& options) { options.knobs.noise = NoiseKind::Assumed; }
inline void steady_light(PipelineOptions& options) { options.knobs.light = LightKind::Steady; }
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
    {"state", kWalk, Preset::Balanced, EmitLayer::State, leave, 41.2, 37.9, 0.0545, 0.0045},
    {"state, look-ahead 0", kWalk, Preset::Balanced, EmitLayer::State, no_look_ahead, 39.6, 35.55, 0.073,
     0.008},
    {"state, look-ahead 1", kWalk, Preset::Balanced, EmitLayer::State, one_frame_ahead, 41.2, 38.4, 0.0565,
     0.0045},
    {"state, quick pan", kPan, Preset::Balanced, EmitLayer::State, leave, 42.45, 39.1, 0.0284, 0.0045},
    {"state, few photons", kDim, Preset::Balanced, EmitLayer::State, leave, 35.2, 32.4, 0.078, 0.0068},
    {"state, raw", kRaw, Preset::Balanced, EmitLayer::State, leave, 37.12, 36.43, 0.0505, 0.0017},
    {"state, raw, lamps on the mains", kMains, Preset::Balanced, EmitLayer::State, leave, 32.1, 29.2, 0.107,
     0.0195},
    {"state, lamps that flicker", kLamps, Preset::Balanced, EmitLayer::State, leave, 37.2, 36.4, 0.05, 0.004},
    {"merged, fast", kShortWalk, Preset::Fast, EmitLayer::Merged, leave, 41, 38.1, 0.059, 0.005},
    {"merged, balanced", kShortWalk, Preset::Balanced, EmitLayer::Merged, leave, 41.4, 38.8, 0.0547, 0.0045},
    {"merged, best", kShortWalk, Preset::Best, EmitLayer::Merged, leave, 41.4, 38.8, 0.0547, 0.0045},
    {"field, fast", kShortWalk, Preset::Fast, EmitLayer::Field, leave, 38.1, 36.1, 0.079, 0.0125},
};

// Without the part the picture must lose this much; otherwise the part is useless or not active.
struct PartWorth {
  const char* part;
  FloorClip clip;
  Change without;
  double psnr_mu_db, flicker_stops;  // loses at least; negative where the part may cost a little of it
};
inline constexpr PartWorth kPartWorths[] = {
    {"look-ahead", kWalk, no_look_ahead, 1.5, 0.0165},
    {"shrinkage", kWalk, no_shrinkage, 1.1, 0.004},
    {"warp variance", kWalk, no_warp_variance, 2.25, 0.0065},
    {"gate", kWalk, no_gate, 0.55, 0},
    {"blur variance", kPan, no_blur_variance, 1.3, 0.0055},
    {"learned noise", kDim, assumed_noise, 2.4, 0.079},
    {"light of each frame", kLamps, steady_light, 5, 0.1},
    {"rolling shutter correction", kDim, no_rolling_shutter, 1.3, 0.0015},
};

// Balanced over fast, which has a coarser flow; best, which has the same, may not be worse than balanced.
inline constexpr double kFinerFlow_db = 0.01, kNotWorse_db = -0.05;

// The field's radiance of unseen pixels: at least so many samples on kShortWalk, and their error (mean
// |log2|) at most this share of the lower bound's that the state holds there.
inline constexpr int kFieldAnswers = 300;
inline constexpr double kFieldErrorShare = 1.03;
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
