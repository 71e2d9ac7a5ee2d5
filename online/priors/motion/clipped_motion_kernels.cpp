// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Eight pixels at a time; those of which none is clipped are left as they are.
#include "online/priors/motion/clipped_motion_kernels.h"

#include "hal/core/picture_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

struct Vectors {
  Lanes x, y;
};

// Where eight pixels of the row are, moved by these vectors.
inline Places places_of(const RowOfPictures& at, int x, Vectors by) {
  return places(lanes(x + kEachLane) + by.x, static_cast<float>(at.y) + by.y, at.rows, at.cols);
}
inline Lanes value_at(const float* picture, const RowOfPictures& at, const Places& there) {
  Lanes value;
  read_between({picture, 1, at.rows, at.cols}, there, [&](int, Lanes read) { value = read; });
  return value;
}
inline Vectors vectors_at(const float* motion, const RowOfPictures& at, const Places& there) {
  Vectors vectors;
  read_between({motion, 2, at.rows, at.cols}, there,
               [&](int d, Lanes read) { (d == 0 ? vectors.x : vectors.y) = read; });
  return vectors;
}

// Takes a motion over, as far as `share` says.
inline void take_over(float* u, float* v, int count, Lanes share, Vectors from) {
  const Lanes x = load_some(u, count), y = load_some(v, count);
  store_some(u, x + share * (from.x - x), count);
  store_some(v, y + share * (from.y - y), count);
}

// How far a motion is taken from the frames around: the frame shows nothing there, and the one after does.
inline Lanes hidden(Lanes clipped) { return smooth_step(0.4f, 0.9f, clipped); }
inline Lanes seen(Lanes clipped_after) { return 1 - smooth_step(0.1f, 0.6f, clipped_after); }

// Calls body(x, count, clipped) for eight pixels of a row after the other.
template <class Body>
inline void in_eights(const float* clipped, int cols, Body&& body) {
  for (int x = 0; x < cols; x += kLanes) {
    const int count = least(cols - x, kLanes);
    body(x, count, load_some(clipped + x, count));
  }
}

void go_on(const ContinuedRow& r) {
  constexpr float kKept = 0.9f;  // of what was measured, for each frame that continues it
  in_eights(r.clipped, r.at.cols, [&](int x, int count, Lanes around) {
    const Lanes clipped = smooth_step(0.5f, 0.95f, around);
    Lanes measured = all<Lanes>(1);
    if (any_negative(clipped > 0)) {
      const Places there = places_of(r.at, x, {load_some(r.u + x, count), load_some(r.v + x, count)});
      const Lanes still = value_at(r.measured, r.at, there), share = clipped * smooth_step(0, 1, still);
      measured = 1 - share * (1 - kKept * still);
      const Vectors last = vectors_at(r.last, r.at, there);
      take_over(r.u + x, r.v + x, count, share, {r.ratio * last.x, r.ratio * last.y});
    }
    store_some(r.measured_now + x, measured, count);
  });
}

void bridge(const BridgedRow& r) {
  constexpr int kRounds = 3;
  const float to_after = -(1 - r.share) / r.share;
  in_eights(r.clipped, r.at.cols, [&](int x, int count, Lanes around) {
    const Lanes clipped = hidden(around);
    if (!any_negative(clipped > 0)) return;
    Vectors back{};
    const auto in_after = [&] { return places_of(r.at, x, {to_after * back.x, to_after * back.y}); };
    for (int round = 0; round < kRounds; ++round) {
      const Vectors after = vectors_at(r.after_to_state, r.at, in_after());
      const Vectors before = vectors_at(r.state_to_after, r.at, places_of(r.at, x, back));
      back = {0.5f * r.share * (after.x - before.x), 0.5f * r.share * (after.y - before.y)};
    }
    const Lanes share = clipped * seen(value_at(r.clipped_after, r.at, in_after()));
    take_over(r.u + x, r.v + x, count, share, back);
    const Lanes measured = load_some(r.measured + x, count);
    store_some(r.measured + x, measured + share * (1 - measured), count);
  });
}

void bridge_ahead(const BridgedAheadRow& r) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(r.at.rows) * r.at.cols;
  const float* own = r.state_to_after + static_cast<std::ptrdiff_t>(r.at.y) * r.at.cols;
  in_eights(r.clipped, r.at.cols, [&](int x, int count, Lanes around) {
    const Lanes clipped = hidden(around);
    if (!any_negative(clipped > 0)) return;
    const Vectors whole{load_some(own + x, count), load_some(own + plane + x, count)};
    const Lanes share = clipped * seen(value_at(r.clipped_after, r.at, places_of(r.at, x, whole)));
    take_over(r.u + x, r.v + x, count, share, {r.share * whole.x, r.share * whole.y});
  });
}

}  // namespace

extern const ClippedMotionKernels kClippedMotionKernels;
const ClippedMotionKernels kClippedMotionKernels{&go_on, &bridge, &bridge_ahead};

}  // namespace hdrcam::HDRCAM_TARGET
