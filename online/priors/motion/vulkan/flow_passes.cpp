#include "online/priors/motion/vulkan/flow_passes.h"

#include "capture/clip_policy.h"
#include "online/priors/motion/vulkan/derive.comp.h"
#include "online/priors/motion/vulkan/enlarge.comp.h"
#include "online/priors/motion/vulkan/halve.comp.h"
#include "online/priors/motion/vulkan/linearise.comp.h"
#include "online/priors/motion/vulkan/relax.comp.h"
#include "online/priors/motion/vulkan/search.comp.h"
#include "online/priors/motion/vulkan/search_far.comp.h"
#include "online/priors/motion/vulkan/spread.comp.h"
#include "online/priors/motion/vulkan/start.comp.h"
#include "online/priors/motion/vulkan/weigh.comp.h"

namespace hdrcam {
namespace {

constexpr int kDirections = 2;
constexpr int kGroup = 64;                                     // GROUP of the searches
static_assert(kGroup == flow_constants::kStrip * kPatchSize);  // search.comp: a strip by a group

struct SizeConstants {
  int rows, cols;
};
SizeConstants size_of(const GpuPicture& level) { return {level.rows, level.cols}; }

struct PatchConstants {
  int rows, cols, patch_rows, patch_cols, stride;
};
PatchConstants patches_of(const GpuFlowLevel& level) {
  return {level.pictures.rows, level.pictures.cols, level.grid.rows, level.grid.cols, level.grid.stride};
}

GpuGrid pixels_of(const GpuPicture& level) { return {level.cols, level.rows, kDirections}; }

}  // namespace

Result<FlowPasses> FlowPasses::make(GpuDevice& device) {
  const std::array<GpuShader, kPasses> shaders{{{"flow halve", k_halve, 2},
                                                {"flow derive", k_derive, 1},
                                                {"flow start", k_start, 5},
                                                {"flow search", k_search, 4, kGroup},
                                                {"flow search far", k_search_far, 3, kGroup},
                                                {"flow spread", k_spread, 3},
                                                {"flow linearise", k_linearise, 3},
                                                {"flow weigh", k_weigh, 4},
                                                {"flow relax", k_relax, 3},
                                                {"flow enlarge", k_enlarge, 2}}};
  FlowPasses passes(device);
  passes.kernels_ = TRY(kernels_of(device, shaders));
  return passes;
}

void FlowPasses::halve(const GpuPicture& finer, const GpuPicture& level) const {
  const struct {
    int rows, cols, finer_rows, finer_cols;
  } constants{level.rows, level.cols, finer.rows, finer.cols};
  run(kHalve, {*finer, *level}, constants, pixels_of(level));
}

void FlowPasses::derive(const GpuPicture& level) const {
  run(kDerive, {*level}, size_of(level), pixels_of(level));
}

void FlowPasses::start(const GpuFlowLevel& level, const GpuFlowGuess& guess, const GpuFlow& coarser,
                       const GpuBuffer& patches, const GpuBuffer& starts) const {
  struct Constants {  // as start.comp lays them out
    int rows, cols, scale, patch_rows, patch_cols, stride;
    int given_rows, given_cols, coarser_rows, coarser_cols;
    float brightest;
    alignas(8) int guided[kDirections];
    int first_given[kDirections], carried[kDirections];
    float share[kDirections];
  } constants{.rows = level.pictures.rows,
              .cols = level.pictures.cols,
              .scale = level.scale,
              .patch_rows = level.grid.rows,
              .patch_cols = level.grid.cols,
              .stride = level.grid.stride,
              .given_rows = guess.vectors.rows,
              .given_cols = guess.vectors.cols,
              .coarser_rows = coarser.rows,
              .coarser_cols = coarser.cols,
              .brightest = clip_policy::kMotionShare.brightest,
              .guided = {},
              .first_given = {},
              .carried = {},
              .share = {}};
  for (std::size_t d = 0; d < kDirections; ++d) {
    const auto& [given, carried, first, share] = guess.directions[d];
    constants.guided[d] = given ? 1 : 0, constants.first_given[d] = first;
    constants.carried[d] = carried ? 1 : 0, constants.share[d] = share;
  }
  run(kStart, {*level.pictures, *guess.vectors, &coarser.buffer, &patches, &starts}, constants,
      {level.grid.cols, level.grid.rows, kDirections});
}

void FlowPasses::search(const GpuFlowLevel& level, int steps, std::array<bool, 2> guided,
                        const GpuBuffer& starts, const GpuBuffer* others, const GpuBuffer& patches) const {
  using flow_constants::kStrip;
  const struct {  // as search.comp lays them out
    PatchConstants patches;
    int steps, others;
    alignas(8) int guided[kDirections];
  } constants{patches_of(level), steps, others != nullptr ? 1 : 0, {guided[0] ? 1 : 0, guided[1] ? 1 : 0}};
  const int strips = (level.grid.rows + kStrip - 1) / kStrip;
  run(kSearch, {*level.pictures, &starts, others != nullptr ? others : &starts, &patches}, constants,
      {kGroup * strips, 1, kDirections});
}

void FlowPasses::search_far(const GpuFlowLevel& level, const GpuBuffer& patches, const GpuBuffer& far) const {
  run(kSearchFar, {*level.pictures, &patches, &far}, patches_of(level),
      {kGroup * level.grid.cols, level.grid.rows, kDirections});
}

void FlowPasses::spread(const GpuFlowLevel& level, const GpuBuffer& patches, const GpuBuffer& flow) const {
  run(kSpread, {*level.pictures, &patches, &flow}, patches_of(level), pixels_of(level.pictures));
}

void FlowPasses::linearise(const GpuPicture& level, const GpuBuffer& flow, const GpuBuffer& data) const {
  run(kLinearise, {*level, &flow, &data}, size_of(level), pixels_of(level));
}

void FlowPasses::weigh(const GpuPicture& level, const GpuBuffer& data, const GpuBuffer& before,
                       const GpuBuffer& flow, const GpuBuffer& system) const {
  run(kWeigh, {&data, &before, &flow, &system}, size_of(level), pixels_of(level));
}

void FlowPasses::sweep(const GpuPicture& level, const GpuBuffer& system, const GpuBuffer& flow,
                       const GpuBuffer& next) const {
  for (int odd = 0; odd < 2; ++odd) {
    const struct { int rows, cols, odd; } constants{level.rows, level.cols, odd};
    run(kRelax, {&system, &flow, &next}, constants, {level.cols, (level.rows + 1) / 2, kDirections});
  }
}

void FlowPasses::enlarge(const GpuFlow& half, const GpuFlow& whole) const {
  const struct {
    int rows, cols, half_rows, half_cols;
  } constants{whole.rows, whole.cols, half.rows, half.cols};
  run(kEnlarge, {&half.buffer, &whole.buffer}, constants, {whole.cols, whole.rows, kFlowVectorPlanes});
}

}  // namespace hdrcam
