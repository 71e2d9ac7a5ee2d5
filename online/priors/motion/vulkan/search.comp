#version 450
#extension GL_GOOGLE_include_directive : require
// The inverse search of a strip of patches by one work group: a sweep forward, which takes over neighbours'
// answers from the left and above, and one back. A row of patches is one patch behind the row before it, so
// that all rows are searched at once in the order of one after the other; eight invocations are a patch, each
// one column of it.
#define GROUP 64
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, patch_rows, patch_cols, stride, steps;
  int others;    // 1: there are other guesses, kNowhere for some patches
  ivec2 guided;  // by direction: `starts` are first guesses
};
READS(0, Level, level)
READS(1, Starts, starts)
READS(2, Others, other_guesses)
layout(std430, set = 0, binding = 3) coherent buffer Patches { float patches[]; };
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/patches.glsl"

shared vec4 parts[2][GROUP];
shared vec2 latest[2][kStrip];  // what each row of patches found last, in the step before and in this one
int turn = 0;

// The sums over a patch of what its columns have.
vec4 over_patch(vec4 part) {
  const uint me = gl_LocalInvocationIndex, first = me / kPatchSize * kPatchSize;
  parts[turn][me] = part;
  barrier();
  vec4 sum = vec4(0);
  for (uint k = 0; k < kPatchSize; ++k) sum += parts[turn][first + k];
  turn = 1 - turn;  // the next sums are not written where others still read these
  return sum;
}

// A column of a patch and its derivatives, and of the whole patch the structure tensor (codes^2 per pixel^2),
// the mean difference left out: the two pictures may differ by an offset.
struct Patch {
  ivec2 corner;
  float gray[kPatchSize], dx[kPatchSize], dy[kPatchSize];
  vec2 mean;
  float xx, xy, yy;
};
struct Fit {
  float error;  // codes^2 over the patch
  vec2 next;    // the step from there
};

int direction, lane;
Patch mine;

void take_patch(int row, int col) {
  mine.corner = corner_of(row, col);
  const int gray = own_plane(direction);
  vec4 part = vec4(0);
  float cross = 0;
  for (int r = 0; r < kPatchSize; ++r) {
    const int pixel = at(gray, mine.corner.y + r, mine.corner.x + lane), plane = rows * cols;
    mine.gray[r] = level[pixel];
    const float dx = level[pixel + plane], dy = level[pixel + 2 * plane];
    mine.dx[r] = dx, mine.dy[r] = dy;
    part += vec4(dx, dy, dx * dx, dy * dy), cross += dx * dy;
  }
  const vec4 total = over_patch(part);
  const float total_cross = over_patch(vec4(cross)).x;
  mine.mean = total.xy / kPixels;
  mine.xx = total.z - total.x * mine.mean.x, mine.yy = total.w - total.y * mine.mean.y;
  mine.xy = total_cross - total.x * mine.mean.y;
}

// The step of Gauss and Newton, damped (Levenberg) by what the patch differs by: that much of the difference
// may be noise, and the motion is expected to be this far from where the step begins.
vec2 step_of(float error, vec2 b) {
  const float damping = kFlat + error / (kPixels * kExpected2);
  const float xx = mine.xx + damping, yy = mine.yy + damping, xy = mine.xy;
  const float scale = -1 / (xx * yy - xy * xy);
  return scale * vec2(yy * b.x - xy * b.y, xx * b.y - xy * b.x);
}

float between(int y, int x, float fx) {
  const int other = other_plane(direction);
  return mix(near(other, y, x), near(other, y, x + 1), fx);
}

// How well the patch is explained there, and the step from there.
Fit look(vec2 by) {
  const Window to = window(mine.corner, by);
  vec4 part = vec4(0);
  float above = between(to.at.y, to.at.x + lane, to.between.x);
  for (int r = 0; r < kPatchSize; ++r) {
    const float below = between(to.at.y + r + 1, to.at.x + lane, to.between.x);
    const float d = mix(above, below, to.between.y) - mine.gray[r];
    above = below;
    part += vec4(d, d * d, d * mine.dx[r], d * mine.dy[r]);
  }
  const vec4 total = over_patch(part);
  const float error = total.y - total.x * total.x / kPixels;
  return Fit(error, step_of(error, total.zw - total.x * mine.mean));
}

vec2 best;
Fit fit;

// All invocations of a group look, whether their patch has such a guess or not.
void consider(bool there, vec2 guess) {
  there = there && guess != best;
  const Fit other = look(there ? guess : best);
  if (there && other.error + kLeastBetter < (1 - kBetterShare) * fit.error) best = guess, fit = other;
}

void descend() {
  const vec2 first = best;
  bool goes_on = true;
  for (int i = 0; i < steps; ++i) {
    goes_on = goes_on && dot(fit.next, fit.next) > kLeastStep2;
    const vec2 next = goes_on ? best + fit.next : best;
    const Fit there = look(next);
    goes_on = goes_on && there.error < fit.error;
    if (goes_on) best = next, fit = there;
  }
  const vec2 way = best - first;
  if (!(dot(way, way) <= kFarthest2)) best = first;
}

vec2 stored(int row, int col) {
  const int u = kVectorPlanes * direction;
  return vec2(patches[of_patch(u, row, col)], patches[of_patch(u + 1, row, col)]);
}

void main() {
  const int me = int(gl_LocalInvocationIndex), strip_row = me / kPatchSize;
  direction = int(gl_WorkGroupID.z), lane = me % kPatchSize;
  const int first = int(gl_WorkGroupID.x) * kStrip, in_strip = min(kStrip, patch_rows - first);
  const int row = min(first + strip_row, patch_rows - 1);
  const bool is_row = strip_row < in_strip;
  const int u = kVectorPlanes * direction;
  for (int sweep = 0; sweep < 2; ++sweep) {
    const bool back = sweep == 1;
    const int order = back ? in_strip - 1 - strip_row : strip_row;  // of the rows
    const int before_row = back ? min(strip_row + 1, kStrip - 1) : max(strip_row - 1, 0);
    for (int t = 0; t < patch_cols + in_strip - 1; ++t) {
      const int k = t - order, now = t & 1;
      const bool is_due = is_row && k >= 0 && k < patch_cols;
      const int along = clamp(k, 0, patch_cols - 1), col = back ? patch_cols - 1 - along : along;
      take_patch(row, col);
      const vec2 found = stored(row, col);
      const int i = of_patch(u, row, col), plane = patch_rows * patch_cols;
      if (!back && guided[direction] != 0) {
        best = vec2(starts[i], starts[i + plane]);
        fit = look(best);
        consider(true, found);
      } else {
        best = found;
        fit = look(best);
      }
      if (!back && others != 0)
        consider(other_guesses[i] != kNowhere, vec2(other_guesses[i], other_guesses[i + plane]));
      consider(k > 0, latest[1 - now][strip_row]);
      consider(order > 0, latest[1 - now][before_row]);
      descend();
      if (lane == 0 && is_due) {
        latest[now][strip_row] = best;
        patches[i] = best.x, patches[i + plane] = best.y;
      }
      barrier();
    }
    memoryBarrierBuffer();
    barrier();
  }
}
