#version 450
#extension GL_GOOGLE_include_directive : require
// Each patch that its answer does not explain is compared with every place within reach, one patch by one work
// group: whole pixels, kNowhere for patches that were not looked for or not found.
#define GROUP 64
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, patch_rows, patch_cols, stride;
};
READS(0, Level, level)
READS(1, Patches, patches)
WRITES(2, Far, far)
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/patches.glsl"

shared float errors[GROUP];
shared int places[GROUP];

void main() {
  const int me = int(gl_LocalInvocationIndex);
  const int row = int(gl_WorkGroupID.y), col = int(gl_WorkGroupID.x), direction = int(gl_WorkGroupID.z);
  const int own = own_plane(direction), other = other_plane(direction), u = kVectorPlanes * direction;
  const ivec2 corner = corner_of(row, col);
  const Window to =
      window(corner, vec2(patches[of_patch(u, row, col)], patches[of_patch(u + 1, row, col)]));
  vec2 texture_sums = vec2(0), error_sums = vec2(0);  // of the values and of their squares
  for (int k = 0; k < kPatchSize * kPatchSize; ++k) {
    const int r = k / kPatchSize, c = k % kPatchSize;
    const float code = level[at(own, corner.y + r, corner.x + c)];
    const float d = between_pixels(other, to.at + ivec2(c, r), to.between) - code;
    texture_sums += vec2(code, code * code), error_sums += vec2(d, d * d);
  }
  const float texture_here = texture_sums.y - texture_sums.x * texture_sums.x / kPixels;
  const float error_here = error_sums.y - error_sums.x * error_sums.x / kPixels;
  const bool wanted = texture_here >= kLeastTexture && error_here >= kExplained * texture_here;

  const ivec2 reach = min(ivec2(cols, rows) / kReach, ivec2(kMostReach));
  const ivec2 least = max(ivec2(0), corner - reach);
  const ivec2 most = min(ivec2(cols, rows) - kPatchSize, corner + reach);
  const int across = most.x - least.x + 1, count = wanted ? across * (most.y - least.y + 1) : 0;
  float best = kWorstError;
  int best_place = 0;
  for (int place = me; place < count; place += GROUP) {
    const int y = least.y + place / across, x = least.x + place % across;
    vec2 sums = vec2(0);
    for (int k = 0; k < kPatchSize * kPatchSize; ++k) {
      const int r = k / kPatchSize, c = k % kPatchSize;
      const float d = level[at(other, y + r, x + c)] - level[at(own, corner.y + r, corner.x + c)];
      sums += vec2(d, d * d);
    }
    const float error = sums.y - sums.x * sums.x / kPixels;
    if (error < best) best = error, best_place = place;
  }
  errors[me] = best, places[me] = best_place;
  barrier();
  if (me != 0) return;
  for (int k = 1; k < GROUP; ++k)
    if (errors[k] < best || (errors[k] == best && places[k] < best_place))
      best = errors[k], best_place = places[k];
  const bool found = wanted && best <= min(kFound * texture_here, kFarBetter * error_here);
  const ivec2 way = least + ivec2(best_place % across, best_place / across) - corner;
  for (int c = 0; c < 2; ++c) far[of_patch(u + c, row, col)] = found ? float(way[c]) : kNowhere;
}
