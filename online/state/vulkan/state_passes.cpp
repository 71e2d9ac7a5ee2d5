#include "online/state/vulkan/state_passes.h"

#include "capture/clip_policy.h"
#include "online/pictures/picture_kernels.h"
#include "online/pictures/vulkan/box_mean.comp.h"
#include "online/pictures/vulkan/largest_around.comp.h"
#include "online/pictures/vulkan/local_contrast.comp.h"
#include "online/pictures/vulkan/log_radiance.comp.h"
#include "online/pictures/vulkan/warp.comp.h"
#include "online/pictures/warp.h"
#include "online/state/pass_constants.h"
#include "online/state/sample_residuals.h"
#include "online/state/vulkan/age.comp.h"
#include "online/state/vulkan/blur.comp.h"
#include "online/state/vulkan/disagreement.comp.h"
#include "online/state/vulkan/follow.comp.h"
#include "online/state/vulkan/gate.comp.h"
#include "online/state/vulkan/guess.comp.h"
#include "online/state/vulkan/residuals.comp.h"
#include "online/state/vulkan/sample.comp.h"
#include "online/state/vulkan/update.comp.h"

namespace hdrcam {
namespace {

constexpr int kColours = 3;  // planes, the first ones of a state

float square(float v) { return v * v; }

struct WarpConstants {
  int rows, cols, cubic_planes;
  float limit = 0, dark = 0;
};

}  // namespace

Result<GpuTables> GpuTables::make(GpuDevice& device) {
  using namespace pass_constants;
  constexpr std::size_t kCurves = 3 * (kCodes + 2 * kRoots), kExcess = 3 * VarianceExcess::kBins;
  GpuTables tables;
  tables.curves = TRY(device.buffer(kCurves * sizeof(float)));
  tables.excess = TRY(device.buffer(kExcess * sizeof(float)));
  return tables;
}

void GpuTables::take(const ExposureTables& tables, GpuWork& work) {
  const auto add = [this](std::span<const float> table) {
    staged.insert(staged.end(), table.begin(), table.end());
  };
  staged.clear();
  for (int c = 0; c < 3; ++c) add(tables.radiances(c));
  for (int c = 0; c < 3; ++c) add(tables.variances(c));
  for (int c = 0; c < 3; ++c) add(tables.hidden(c));
  work.upload(std::as_bytes(std::span(staged)), *curves);
  work.upload(std::as_bytes(std::span(tables.excess().bins)), *excess);
  exposure = tables.exposure(), texture_error = tables.texture_error(), ringing = tables.ringing();
  doubts_textures = tables.doubts_textures();
}

Result<PassRoom> PassRoom::make(GpuDevice& device, int rows, int cols) {
  const auto picture = [&](int planes) { return GpuPicture::make(device, planes, rows, cols); };
  PassRoom room;
  room.mean = TRY(picture(3));
  room.guess = TRY(picture(3));
  room.detail = TRY(picture(3));
  room.logs = TRY(picture(kStatePlanes));
  room.found = TRY(picture(kFoundPlanes));
  room.found_mean = TRY(picture(kFoundPlanes));
  return room;
}

Result<StatePasses> StatePasses::make(GpuDevice& device, const StateOptions& options) {
  const std::array<GpuShader, kPasses> shaders{{{"log_radiance", k_log_radiance, 2},
                                                {"warp", k_warp, 4},
                                                {"box_mean", k_box_mean, 2},
                                                {"local_contrast", k_local_contrast, 3},
                                                {"sample", k_sample, 4},
                                                {"blur", k_blur, 3},
                                                {"disagreement", k_disagreement, 6},
                                                {"gate", k_gate, 5},
                                                {"age", k_age, 6},
                                                {"residuals", k_residuals, 6},
                                                {"guess", k_guess, 3},
                                                {"update", k_update, 9},
                                                {"largest_around", k_largest_around, 3},
                                                {"follow", k_follow, 3}}};
  StatePasses passes(device, options);
  passes.kernels_ = TRY(kernels_of(device, shaders));
  return passes;
}

void StatePasses::warp(const GpuPicture& in, const GpuPicture& motion, const GpuPicture& out) const {
  run(kWarp, {*in, *motion, *out, *in}, WarpConstants{in.rows, in.cols, kColours}, out.grid());
}

void StatePasses::warp_state(const GpuPicture& in, const GpuPicture& motion, const PassRoom& room,
                             const GpuPicture& out) const {
  const struct {
    int rows, cols, radiance_planes;
    float dark;
  } logarithm{in.rows, in.cols, kColours, kDarkRadiance};
  run(kLogRadiance, {*in, *room.logs}, logarithm, in.grid());
  run(kWarp, {*room.logs, *motion, *out, *in},
      WarpConstants{in.rows, in.cols, kColours, kMostRinging, kDarkRadiance}, out.grid());
}

void StatePasses::box_mean(const GpuPicture& in, int radius, const GpuPicture& out) const {
  const struct { int rows, cols, radius; } constants{in.rows, in.cols, radius};
  run(kBoxMean, {*in, *out}, constants, out.grid());
}

void StatePasses::local_contrast(const GpuPicture& in, const GpuPicture& mean,
                                 const GpuPicture& contrast) const {
  const struct { int rows, cols; } constants{in.rows, in.cols};
  run(kLocalContrast, {*in, *mean, *contrast}, constants, mean.grid());
}

void StatePasses::sample(const GpuPicture& codes, const GpuPicture& brightest, const GpuTables& tables,
                         const GpuPicture& samples) const {
  using namespace clip_policy;
  const struct {
    int rows, cols;
    float fade_begin, fade_end, compare_fade_begin, compare_fade_end, compare_dark_begin, compare_dark_end;
  } constants{codes.rows,        codes.cols,      kFadeBegin,        kFadeEnd,
              kCompareFadeBegin, kCompareFadeEnd, kCompareDarkBegin, kCompareDarkEnd};
  run(kSample, {*codes, *brightest, tables.curves.get(), *samples}, constants, codes.grid());
}

void StatePasses::model_blur(const GpuPicture& state, const GpuPicture& motion, float fraction,
                             const GpuPicture& samples) const {
  const struct {
    int rows, cols;
    float fraction;
  } constants{state.rows, state.cols, fraction};
  run(kBlur, {*state, *motion, *samples}, constants, {state.cols, state.rows, 3});
}

void StatePasses::gate(const GpuSeen& seen, const GpuPicture& motion, const PassRoom& room,
                       const GpuPicture& gate, const GpuPicture& contrast) const {
  const auto& [state, samples, tables, unseen_variance] = seen;
  const FusionOptions& o = options_.fusion;
  local_contrast(state, room.mean, contrast);
  const struct {
    int rows, cols;
    float unseen_from, exposure, relative2, texture2, blur_tolerance;
  } apart{state.rows,
          state.cols,
          unseen_variance,
          tables.exposure,
          square(o.chi2_relative),
          square(o.chi2_texture),
          o.blur_tolerance};
  run(kDisagreement, {*state, *samples, *room.mean, *contrast, tables.curves.get(), *room.found}, apart,
      room.found.pixels());
  box_mean(room.found, 2, room.found_mean);
  const struct {
    int rows, cols;
    float tolerance, scale, least;
  } constants{state.rows, state.cols, o.chi2_tolerance, o.chi2_scale, o.gate_floor};
  run(kGate, {*state, *samples, *room.found_mean, *motion, *gate}, constants, gate.pixels());
}

void StatePasses::age(const GpuSeen& seen, const GpuMoved& moved, const GpuPicture& gate) const {
  const auto& [state, samples, tables, unseen_variance] = seen;
  const struct {
    int rows, cols;
    float growth, relative2, misalignment2, gate_floor, unseen_from, lost_variance;
  } constants{state.rows,
              state.cols,
              1 + options_.variance_growth,
              square(options_.relative_growth),
              square(options_.fusion.misalignment),
              options_.fusion.gate_floor,
              unseen_variance,
              kUnseenVariance};
  run(kAge, {*state, *moved.contrast, *moved.motion, *gate, *samples, tables.curves.get()}, constants,
      moved.contrast.grid());
}

void StatePasses::residuals(const GpuSeen& seen, const GpuPicture& motion, const GpuPicture& found) const {
  const auto& [state, samples, tables, unseen_variance] = seen;
  constexpr ResidualSampling kHow = kResidualSampling;
  static_assert(kHow.stride_px == 2);
  const struct {
    int rows, cols, found_rows, found_cols, line_step, bins;
    float unseen_from, exposure, least_confidence, misalignment, relative2;
  } constants{state.rows,
              state.cols,
              found.rows,
              found.cols,
              kHow.line_step_px(state.rows, state.cols),
              static_cast<int>(VarianceExcess::kBins),
              unseen_variance,
              tables.exposure,
              kHow.least_confidence,
              kHow.misalignment,
              square(kHow.relative)};
  run(kResiduals, {*state, *samples, *motion, tables.curves.get(), tables.excess.get(), *found}, constants,
      {found.cols, found.rows, 3});
}

void StatePasses::fuse(Taking taking, const GpuSeen& seen, const GpuPicture& gate, const GpuMoved& moved,
                       const PassRoom& room, const GpuPicture& share) const {
  const auto& [state, samples, tables, unseen_variance] = seen;
  const FusionOptions& o = options_.fusion;
  const struct {
    int rows, cols;
    float unseen_from;
  } choice{state.rows, state.cols, unseen_variance};
  run(kGuess, {*state, *samples, *room.guess}, choice, room.guess.grid());
  if (tables.doubts_textures)
    local_contrast(room.guess, room.mean, room.detail);
  else
    box_mean(room.guess, 1, room.mean);
  const struct {
    int rows, cols, joins, bounded, starts, textured;
    float unseen_from, exposure, relative2, blur_variance, unknown_blur_variance, misalignment2,
        texture_error, ringing;
  } constants{state.rows,
              state.cols,
              taking == Taking::Later ? 1 : 0,
              taking == Taking::Later && !moved.shorter ? 1 : 0,
              taking == Taking::First ? 1 : 0,
              tables.doubts_textures ? 1 : 0,
              unseen_variance,
              tables.exposure,
              square(o.relative_noise),
              o.blur_variance,
              o.unknown_blur_variance,
              static_cast<float>(moved.intervals) * square(o.misalignment),
              tables.texture_error,
              tables.ringing};
  run(kUpdate,
      {*state, *samples, *room.mean, tables.curves.get(), *gate, *moved.contrast, *moved.motion, *share,
       *room.detail},
      constants, share.pixels());
}

void StatePasses::update(const GpuSeen& seen, const PassRoom& room, const GpuPicture& share,
                         SampleOrder order) const {
  const GpuPicture& unread = room.mean;  // a kernel has all its buffers
  fuse(order == SampleOrder::FirstFrame ? Taking::First : Taking::Own, seen, unread, {unread, unread}, room,
       share);
}

void StatePasses::join(const GpuSeen& seen, const GpuPicture& gate, const GpuMoved& moved,
                       const PassRoom& room, const GpuPicture& share) const {
  fuse(Taking::Later, seen, gate, moved, room, share);
}

void StatePasses::largest_around(const GpuPicture& in, const GpuPicture& motion,
                                 const GpuPicture& out) const {
  const struct { int rows, cols; } constants{in.rows, in.cols};
  run(kLargestAround, {*in, *motion, *out}, constants, out.grid());
}

void StatePasses::follow(const GpuPicture& motion, const GpuPicture& path, const GpuPicture& longer) const {
  const struct { int rows, cols; } constants{motion.rows, motion.cols};
  run(kFollow, {*motion, *path, *longer}, constants, longer.pixels());
}

}  // namespace hdrcam
