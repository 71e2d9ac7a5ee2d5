// The result of a walk over the knobs (cost_walk.h) for people and programs: a table in Markdown, JSON, and a
// page with charts of quality and flicker against time. Reentrant.
#pragma once

#include <span>
#include <string>

#include "firmware_host/bench/cost_walk.h"

namespace hdrcam {

// The points whose time no other point of at least their PSNR-mu undercuts: the Pareto front.
std::vector<bool> on_the_front(std::span<const PointCost> points);

// The means over the clips, one row per point, ordered by time; with a mark for those on the front.
std::string cost_table(std::span<const PointCost> costs);
// The walk that the pages tell of.
struct MeasuredWalk {
  std::span<const PointCost> costs;  // of every point and clip
  std::string command;               // that measures them again
  int threads = 1;
};

// Every point and clip, the means, the machine and the command.
std::string cost_json(const MeasuredWalk& walk);
// A page in HTML: the charts of the means, and of each clip.
std::string cost_page(const MeasuredWalk& walk);

}  // namespace hdrcam
