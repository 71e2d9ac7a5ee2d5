// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Eight pixels at a time; those of which none is clipped are left as they are.
#include "online/priors/motion/clipped_motion_kernels.h"

#include "hal/core/picture_lanes.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

struct Vectors {
  Lanes x, y;
};
inline Vectors operator+(Vectors a, Vectors b) { return {a.x + b.x, a.y + b.y}; }
inline Vectors operator-(Vectors a, Vectors b) { return {a.x - b.x, a.y - b.y}; }
inline Lanes squared(Vectors v) { return v.x * v.x + v.y * v.y; }

// landing_cells() of landing.h: this file may include nothing with inline code.
constexpr int cells_along(int pixels) { return (pixels + kLandingCell - 1) / kLandingCell; }

// What pictures hold where eight pixels of the row are, moved by these vectors: at the nearest pixels, which
// is as good as between them and two to three times as fast (docs/decisions/kernels.md).
inline Nearest place_of(const RowOfPictures& at, int x, Vectors by) {
  return nearest(lanes(x + kEachLane) + by.x, static_cast<float>(at.y) + by.y, at.rows, at.cols);
}
inline Vectors vectors_at(const float* motion, const RowOfPictures& at, const Nearest& there) {
  return {read(motion, there), read(motion + static_cast<std::ptrdiff_t>(at.rows) * at.cols, there)};
}

// The vectors at eight pixels of the row.
inline Vectors own_vectors(const float* motion, const RowOfPictures& at, int x, int count) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(at.rows) * at.cols;
  const float* own = motion + static_cast<std::ptrdiff_t>(at.y) * at.cols + x;
  return {load_some(own, count), load_some(own + plane, count)};
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

// How far a change of a motion is believed: all of the motion was measured.
inline Lanes trusted(Lanes measured) { return smooth_step(0.9f, 1, measured); }

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
    if (r.predicted == nullptr) {
      measured = 1 - clipped * (1 - kKept);
    } else if (any_negative(clipped > 0)) {
      const Nearest there = place_of(r.at, x, {load_some(r.u + x, count), load_some(r.v + x, count)});
      const Lanes still = read(r.measured, there), share = clipped * smooth_step(0, 1, still);
      measured = 1 - share * (1 - kKept * still);
      const Vectors next = vectors_at(r.predicted, r.at, there);
      take_over(r.u + x, r.v + x, count, share, {r.ratio * next.x, r.ratio * next.y});
    }
    store_some(r.measured_now + x, measured, count);
  });
}

// How far the path leads away, at the time of the clipped frame, from the one at constant velocity: for D and
// L of PathAhead, of which `measured` was measured.
inline Vectors bend_of(const PathAhead& path, Vectors whole, Vectors last, Lanes measured) {
  constexpr float kShare = 0.6f;         // errors of two flows are in it
  constexpr float kPerPixel2 = 1 / 4.f;  // a bend of 2 px counts half: few objects turn so, a wrong flow does
  const float earlier = 1 / path.before;
  const Lanes scale = trusted(measured) * (kShare * path.share * (1 - path.share) / (1 + path.before));
  const Vectors bend{scale * (whole.x + earlier * last.x), scale * (whole.y + earlier * last.y)};
  const Lanes limit = 1 / (1 + kPerPixel2 * squared(bend));
  return {limit * bend.x, limit * bend.y};
}

inline Vectors either(Whole which, Vectors a, Vectors b) { return {which ? a.x : b.x, which ? a.y : b.y}; }

// Whether motions there and back, read where the former leads, do not come home.
inline Whole lost(Vectors there, Vectors back) { return squared(there + back) > kHome2; }

// A pixel of the clipped frame: its motion to the state, D, and both flows where these lead.
struct Crossing {
  Vectors back, whole, before, after;
};

// The crossing that the flows tell where this one leads.
inline Crossing step(const RowOfPictures& at, const PathAhead& path, int x, const Crossing& from) {
  const Nearest there = place_of(at, x, from.back);
  Crossing to;
  to.after = vectors_at(path.after_to_state, at, place_of(at, x, from.back + from.whole));
  to.before = vectors_at(path.state_to_after, at, there);
  to.whole = {0.5f * (to.before.x - to.after.x), 0.5f * (to.before.y - to.after.y)};
  to.back = {-path.share * to.whole.x, -path.share * to.whole.y};
  if (path.last != nullptr) {
    const Vectors last = vectors_at(path.last, at, there);
    to.back = to.back + bend_of(path, to.whole, last, read(path.measured, there));
  }
  return to;
}

// A fixed point: where the flows are read is told by what is read.
inline Crossing settle(const RowOfPictures& at, const PathAhead& path, int x, Vectors back, Vectors whole) {
  constexpr int kRounds = 2;
  Crossing crossing{back, whole, {}, {}};
  for (int round = 0; round < kRounds; ++round) crossing = step(at, path, x, crossing);
  return crossing;
}

inline float sum(Lanes v) { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); }

void compare(const CheckedPathRow& r) {
  constexpr float kClipped = 0.05f, kSeen = 0.95f;
  constexpr float kFar2 = 1;  // pixels^2: what differs by more is lost, or something else
  static_assert(kLandingCell == kLanes);
  in_eights(r.clipped, r.at.cols, [&](int x, int count, Lanes around) {
    constexpr Vectors kStill{};
    const Crossing crossing = settle(r.at, r.path, x, kStill, kStill);
    const Vectors off = Vectors{load_some(r.u + x, count), load_some(r.v + x, count)} - crossing.back;
    const Vectors ahead = crossing.back + crossing.whole;
    const Whole within = kEachLane < count;
    const Whole told = within & (around <= kClipped) &
                       (seen(read(r.clipped_after, place_of(r.at, x, ahead))) >= kSeen) &
                       (squared(off) < kFar2);
    CheckedPathCell& cell = r.cells[x / kLandingCell];
    const auto sum_of = [](Whole which, Lanes v) { return sum(which ? v : Lanes{}); };
    cell.pixels += static_cast<float>(count);
    cell.path_u += sum_of(within, crossing.back.x), cell.path_v += sum_of(within, crossing.back.y);
    cell.told += sum_of(told, all<Lanes>(1));
    cell.off_u += sum_of(told, off.x), cell.off_v += sum_of(told, off.y);
    cell.off2 += sum_of(told, squared(off));
  });
}

// Between the middles of a row's cells, at eight pixels of one of them.
inline Lanes between_cells(const float* cells, int cell, int count_of_cells) {
  const float here = cells[cell], left = cells[cell > 0 ? cell - 1 : 0],
              right = cells[cell + 1 < count_of_cells ? cell + 1 : cell];
  const Lanes apart = (lanes(kEachLane) + 0.5f) * (1.f / kLandingCell) - 0.5f;
  return here + (apart < 0 ? apart * (here - left) : apart * (right - here));
}

// Takes over what lands at eight pixels, where it is there; `unseen` becomes 1 where the frame's own motion,
// there and back, leads elsewhere.
inline void take_landed(const BridgedRow& r, int x, int count, Vectors start, Crossing& crossing,
                        Lanes& unseen) {
  constexpr float kFarOff2 = 64;  // pixels^2: what is that far from where it started is something else
  constexpr float kKnown2 = 1;    // pixels^2: what is that near to what lands is what lands
  const Vectors own{load_some(r.u + x, count), load_some(r.v + x, count)};
  const Vectors back{-r.path.share * start.x, -r.path.share * start.y};
  // what will be there without it
  const Vectors known{own.x + unseen * (crossing.back.x - own.x), own.y + unseen * (crossing.back.y - own.y)};
  const Whole differs = squared(known - back) > kKnown2;
  if (!any_negative(differs & (kEachLane < count))) return;
  const Crossing fast = settle(r.at, r.path, x, back, start);
  const Whole there = ~lost(fast.before, fast.after) & (squared(fast.whole - start) < kFarOff2);
  if (!any_negative(there)) return;
  unseen = there & lost(own, vectors_at(r.from, r.at, place_of(r.at, x, own))) ? all<Lanes>(1) : unseen;
  crossing.back = either(there, fast.back, crossing.back);
  crossing.whole = either(there, fast.whole, crossing.whole);
}

void bridge(const BridgedRow& r) {
  static_assert(kLandingCell == kLanes);
  in_eights(r.clipped, r.at.cols, [&](int x, int count, Lanes around) {
    const float landed_u = r.landed_u[x / kLandingCell], landed_v = r.landed_v[x / kLandingCell];
    const bool lands = landed_u != kNowhere;
    Lanes unseen = hidden(around);
    const bool hides = any_negative(unseen > 0);
    if (!lands && !hides) return;
    constexpr Vectors kStill{};
    Crossing crossing{};
    if (hides) crossing = settle(r.at, r.path, x, kStill, kStill);
    if (lands) take_landed(r, x, count, {all<Lanes>(landed_u), all<Lanes>(landed_v)}, crossing, unseen);
    if (!any_negative(unseen > 0)) return;
    if (r.off_u != nullptr) {
      const int cell = x / kLandingCell, cells = cells_along(r.at.cols);
      crossing.back =
          crossing.back + Vectors{between_cells(r.off_u, cell, cells), between_cells(r.off_v, cell, cells)};
    }
    const Vectors ahead = crossing.back + crossing.whole;
    const Lanes share = unseen * seen(read(r.clipped_after, place_of(r.at, x, ahead)));
    take_over(r.u + x, r.v + x, count, share, crossing.back);
    const Lanes measured = load_some(r.measured + x, count);
    store_some(r.measured + x, measured + share * (1 - measured), count);
  });
}

// Read in the cell that it leads to.
inline Vectors less_what_is_off(const BridgedAheadRow& r, int x, Vectors ahead) {
  const int down = cells_along(r.at.rows), across = cells_along(r.at.cols);
  constexpr float kCells = 1.f / kLandingCell;
  const Nearest there = nearest((lanes(x + kEachLane) + ahead.x + 0.5f) * kCells - 0.5f,
                                (static_cast<float>(r.at.y) + ahead.y + 0.5f) * kCells - 0.5f, down, across);
  return ahead - Vectors{lanes_at(r.off, there.place),
                         lanes_at(r.off + static_cast<std::ptrdiff_t>(down) * across, there.place)};
}

void bridge_ahead(const BridgedAheadRow& r) {
  for (int x = 0; x < r.at.cols; x += kLanes) {
    const int count = least(r.at.cols - x, kLanes);
    const Vectors whole = own_vectors(r.path.state_to_after, r.at, x, count);
    Vectors ahead{r.path.share * whole.x, r.path.share * whole.y};
    Lanes unseen = hidden(read(r.clipped, place_of(r.at, x, ahead)));
    const Whole fast = squared(whole) > kFastOverClipped * kFastOverClipped;
    if (any_negative(fast)) {
      const Vectors own{load_some(r.u + x, count), load_some(r.v + x, count)};
      const Vectors home = vectors_at(r.path.after_to_state, r.at, place_of(r.at, x, whole));
      const Whole mended =
          fast & ~lost(whole, home) & lost(own, vectors_at(r.to, r.at, place_of(r.at, x, own)));
      unseen = mended ? all<Lanes>(1) : unseen;
    }
    if (!any_negative(unseen > 0)) continue;
    if (r.path.last != nullptr) {
      const Lanes measured =
          load_some(r.path.measured + static_cast<std::ptrdiff_t>(r.at.y) * r.at.cols + x, count);
      ahead = ahead - bend_of(r.path, whole, own_vectors(r.path.last, r.at, x, count), measured);
    }
    if (r.off != nullptr) ahead = less_what_is_off(r, x, ahead);
    const Lanes share = unseen * seen(read(r.clipped_after, place_of(r.at, x, whole)));
    take_over(r.u + x, r.v + x, count, share, ahead);
  }
}

void predict(const PredictedRow& r) {
  constexpr float kShare = 0.5f;   // of the change that goes on
  constexpr float kPerPixel2 = 1;  // a change of 1 px counts half
  for (int x = 0; x < r.at.cols; x += kLanes) {
    const int count = least(r.at.cols - x, kLanes);
    const Vectors now{load_some(r.u + x, count), load_some(r.v + x, count)};
    const Nearest there = place_of(r.at, x, now);
    const Vectors last = vectors_at(r.last, r.at, there);
    const Vectors change{now.x - r.ratio * last.x, now.y - r.ratio * last.y};
    const Lanes measured =
        trusted(load_some(r.measured + x, count)) * trusted(read(r.measured_before, there));
    const Lanes share = kShare * measured / (1 + kPerPixel2 * squared(change));
    store_some(r.next_u + x, now.x + share * change.x, count);
    store_some(r.next_v + x, now.y + share * change.y, count);
  }
}

}  // namespace

extern const ClippedMotionKernels kClippedMotionKernels;
const ClippedMotionKernels kClippedMotionKernels{&go_on, &compare, &bridge, &bridge_ahead, &predict};

}  // namespace hdrcam::HDRCAM_TARGET
