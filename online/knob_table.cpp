// The table of all knobs, in the order of the processing of a frame.
#include "online/knobs.h"

#include <cstddef>
#include <type_traits>
#include <utility>

#include "online/state/look_ahead.h"

namespace hdrcam {
namespace {

constexpr double kAny = 1e9;

// The member at the end of a chain of member pointers.
template <auto... path>
struct Place {
  static auto& in(Knobs& knobs) { return (knobs.*....*path); }
  static const auto& of(const Knobs& knobs) { return (knobs.*....*path); }
  static double get(const Knobs& knobs) { return static_cast<double>(of(knobs)); }
  static void put(Knobs& knobs, double value) {
    in(knobs) = static_cast<std::remove_reference_t<decltype(in(knobs))>>(value);
  }
};

// Of a number.
struct Range {
  double least = 0, most = 0;
  int multiple = 1;
};
struct Words {
  const char* unit = "";
  const char* costs = "nothing";
  const char* gives;
};

template <auto... path>
Knob knob(KnobKind kind, const char* name, const Range& range, const Words& words) {
  return {.name = name,
          .unit = words.unit,
          .kind = kind,
          .least = range.least,
          .most = range.most,
          .multiple = range.multiple,
          .costs = words.costs,
          .gives = words.gives,
          .get = &Place<path...>::get,
          .put = &Place<path...>::put};
}
template <auto... path>
Knob whole(const char* name, const Range& range, const Words& words) {
  return knob<path...>(KnobKind::Whole, name, range, words);
}
template <auto... path>
Knob real(const char* name, const Range& range, const Words& words) {
  return knob<path...>(KnobKind::Real, name, range, words);
}
template <auto... path>
Knob choice(const char* name, std::vector<std::string> choices, const Words& words) {
  const double most = static_cast<double>(choices.size()) - 1;
  Knob result = knob<path...>(KnobKind::Choice, name, {0, most}, words);
  result.choices = std::move(choices);
  return result;
}

template <std::size_t term>
Knob loss() {
  return {
      .name = std::string("loss.") + kLosses[term].name,
      .kind = KnobKind::Real,
      .least = 0,
      .most = 100,
      .costs = "only its share of a step",
      .gives = kLosses[term].meaning,
      .get = [](const Knobs& knobs) { return static_cast<double>(knobs.hash_grid.losses[term]); },
      .put = [](Knobs& knobs, double value) { knobs.hash_grid.losses[term] = static_cast<float>(value); }};
}

std::vector<Knob> stream_knobs() {
  using K = Knobs;
  return {
      whole<&K::look_ahead>(
          "look_ahead", {Knobs::kAsSizeAllows, kMaxLookAhead},
          {.unit = "frames; -1: two of pictures of at most 640x480, one of larger ones, for their memory",
           .costs = "latency of as many frames, and one join for each",
           .gives = "clipped and occluded pixels that later frames show"}),
      whole<&K::bootstrap_frames>("bootstrap_frames", {2, 64},
                                  {.unit = "frames",
                                   .costs = "latency of the first emission",
                                   .gives = "a more certain first response and black level"}),
      whole<&K::view_steps>("view_steps", {0, 1000},
                            {.unit = "steps",
                             .costs = "time of the fit, in proportion",
                             .gives = "takes the place of steps where the field itself is seen: its layers, "
                                      "--emit field, novel views"}),
      real<&K::code_noise>(
          "code_noise", {0, 20},
          {.unit = "codes rms",
           .gives = "start value of the estimated compression noise: 0.1 uncompressed, 1 to 2 compressed"}),
      choice<&K::noise>("noise", {"assumed", "learned"},
                        {.costs = "learned: about a tenth of the motion",
                         .gives = "samples weighed by the noise they have"}),
      choice<&K::motion_blur>(
          "motion_blur", {"off", "stated", "shown"},
          {.costs = "a tenth of the time where things move",
           .gives = "sharp frames of what moves; stated: as exposure times say; shown: unless frames "
                    "contradict it, as stills that are played as a video do"}),
      choice<&K::light>(
          "light", {"steady", "followed"},
          {.gives =
               "followed: where lamps on the mains make frames of one exposure brighter and darker, each "
               "frame's own light counts as exposure; steady: every exposure is what it is stated to be"}),
      choice<&K::response>(
          "response", {"curve", "network", "mean", "linear"},
          {.gives = "an unknown response: a curve under the prior of real cameras; for comparison a small "
                    "network without one, the mean of real cameras, or none"}),
      real<&K::state, &StateOptions::variance_growth>(
          "state.variance_growth", {0, 1},
          {.unit = "per frame", .gives = "larger values forget the past sooner"}),
      real<&K::state, &StateOptions::relative_growth>(
          "state.relative_growth", {0, 1},
          {.unit = "of radiance per frame", .gives = "larger values follow changing light"}),
      real<&K::state, &StateOptions::fusion, &FusionOptions::relative_noise>(
          "state.relative_noise", {0, 1},
          {.unit = "of radiance", .gives = "variance outside the noise model"}),
      real<&K::state, &StateOptions::fusion, &FusionOptions::blur_variance>(
          "state.blur_variance", {0, 1000},
          {.gives = "variance of a sample per squared blur that the state predicts"}),
      real<&K::state, &StateOptions::fusion, &FusionOptions::misalignment>(
          "state.misalignment", {0, 10},
          {.unit = "of local contrast", .gives = "variance that a warp adds; 0: none"}),
      real<&K::state, &StateOptions::fusion, &FusionOptions::chi2_tolerance>(
          "state.gate_tolerance", {0, kAny},
          {.unit = "mean chi^2",
           .gives = "largest disagreement at which state and sample count as equal; large: no gate"}),
  };
}

std::vector<Knob> prior_knobs() {
  using K = Knobs;
  return {
      choice<&K::pose>("pose", {"given", "tracked", "fixed"},
                       {.costs = "tracked: a few ms per frame",
                        .gives = "given: from the recording, tracked where it has none; fixed: a tripod"}),
      whole<&K::depth, &DepthOptions::step_px>(
          "depth_step", {1, 8},
          {.unit = "px",
           .costs = "1 costs five times as much as 2",
           .gives = "2 is as accurate as 1; where field_step is auto and nobody looks, at least twice that"}),
      real<&K::dynamic_depth, &DynamicDepthOptions::nearer>(
          "moving_nearer", {0, 10},
          {.costs = "1 % of the time; 0 saves it",
           .gives = "how much nearer a moving region is taken to be than what is around it, unless it stands "
                    "on ground; 0: not guessed"}),
  };
}

std::vector<Knob> field_knobs() {
  using K = Knobs;
  using F = FieldOptions;
  return {
      choice<&K::field>(
          "field", {"none", "hash_grid"},
          {.costs = "pose, depth, fit and view",
           .gives = "depth, novel views, its motion; radiance of unseen pixels where it fills"}),
      choice<&K::field_step>(
          "field_step", {"auto", "1", "2", "4", "8"},
          {.unit = "px",
           .costs = "more is cheaper: memory and time of the field's passes fall with its square",
           .gives = "side of the blocks that are the field's pixels; auto: 1 where the field itself is seen, "
                    "2 to 8 where it only fills"}),
      whole<&K::hash_grid, &F::window, &WindowOptions::frames>(
          "window_frames", {WindowOptions::kFewestFrames, WindowOptions::kMostFrames},
          {.unit = "frames",
           .costs = "memory, 6 MB each at 320x240 and a field_step of 1",
           .gives = "motion that is smooth over the window"}),
      real<&K::hash_grid, &F::window, &WindowOptions::trusted_sigma>(
          "trusted_sigma", {0.01, 1},
          {.unit = "of ln radiance",
           .gives = "sigma of the state at which networks and state have equal weight"}),
      real<&K::hash_grid, &F::margin>(
          "margin", {1, 2},
          {.costs = "resolution of the grids",
           .gives = "width of the window over the picture: allows more camera motion"}),
      whole<&K::hash_grid, &F::shape, &FieldShape::static_grid, &HashGridShape::log2_entries>(
          "static_entries", {10, HashGridShape::kMostLog2Entries},
          {.unit = "log2", .costs = "memory and cache misses", .gives = "detail of static content"}),
      whole<&K::hash_grid, &F::shape, &FieldShape::dynamic_grid, &HashGridShape::log2_entries>(
          "dynamic_entries", {10, HashGridShape::kMostLog2Entries},
          {.unit = "log2", .costs = "memory and cache misses", .gives = "detail of dynamic content"}),
      whole<&K::hash_grid, &F::shape, &FieldShape::static_grid, &HashGridShape::levels>(
          "static_levels", {.least = 2, .most = HashGridShape::kMostLevels, .multiple = 2},
          {.unit = "levels", .costs = "time of a step", .gives = "scales of static content"}),
      whole<&K::hash_grid, &F::shape, &FieldShape::dynamic_grid, &HashGridShape::levels>(
          "dynamic_levels", {.least = 2, .most = HashGridShape::kMostLevels, .multiple = 2},
          {.unit = "levels", .costs = "time of a step", .gives = "scales of dynamic content"}),
      whole<&K::hash_grid, &F::shape, &FieldShape::hidden>("hidden", {.least = 4, .most = 128, .multiple = 4},
                                                           {.unit = "neurons",
                                                            .costs = "time of a step, with its square",
                                                            .gives = "capacity of the two networks"}),
      choice<&K::hash_grid, &F::shape, &FieldShape::branches>(
          "branches", {"both", "static", "dynamic"},
          {.gives = "static and dynamic content, or for comparison one of them alone"}),
      choice<&K::hash_grid, &F::shape, &FieldShape::blend>(
          "blend", {"density_sum", "weight"},
          {.gives = "blending of static and dynamic: densities add up, or the paper's blending weight"}),
  };
}

// How the field is fitted; the steps of a frame are the budget's.
std::vector<Knob> fit_knobs() {
  using K = Knobs;
  using F = FieldOptions;
  return {
      real<&K::hash_grid, &F::newest_share>(
          "newest_share", {0, 1},
          {.gives = "share of the rays in the newest frame; the rest is spread over the window"}),
      real<&K::hash_grid, &F::uniform_share>("uniform_share", {0, 1},
                                             {.gives = "share of uniformly drawn rays; the rest goes where "
                                                       "the state is uncertain or the fit is bad"}),
      real<&K::hash_grid, &F::table_rate>("table_rate", {1e-5, 1}, {.gives = "Adam's rate of the grids"}),
      real<&K::hash_grid, &F::network_rate>("network_rate", {1e-5, 1},
                                            {.gives = "Adam's rate of the networks"}),
      choice<&K::hash_grid, &F::fits_response>(
          "refine_response", {"off", "on"},
          {.costs = "about a tenth of a step", .gives = "a response refined by the photometric loss"}),
      real<&K::hash_grid, &F::response_rate>("response_rate", {0, 1e-2},
                                             {.gives = "Adam's rate of that response"}),
  };
}

std::vector<Knob> frame_budget_knobs() {
  using K = Knobs;
  using B = FrameBudget;
  return {
      choice<&K::budget, &B::flow>(
          "flow", {"coarse", "fast", "medium", "fine"},
          {.costs = "time of the flow call of a frame; fine takes twice as long as fast",
           .gives = "finer motion: fewer pixels lose their history"}),
      choice<&K::budget, &B::flow_over_clipped>(
          "flow_over_clipped", {"coarse", "fast", "medium", "fine"},
          {.costs =
               "time of the second flow call, of frames that are clipped; coarse takes half as long as fast",
           .gives = "finer motion of what a frame does not show because it is clipped; flow, where that is "
                    "coarser"}),
      whole<&K::budget, &B::fit, &FitBudget::steps>(
          "steps", {0, 1000},
          {.unit = "steps",
           .costs = "time of the fit, in proportion",
           .gives = "a field fitted to the frame; 0 renders the state"}),
      whole<&K::budget, &B::fit, &FitBudget::interval>(
          "fit_interval", {1, 64},
          {.unit = "frames",
           .costs = "more is cheaper: the steps are taken at each n-th frame",
           .gives =
               "a field that follows each frame; 1 where the field itself is seen, if nothing else is said"}),
      whole<&K::budget, &B::fit, &FitBudget::rays_per_step>(
          "rays_per_step", {.least = 32, .most = 4096, .multiple = 32},
          {.unit = "rays",
           .costs = "time of a step, in proportion",
           .gives = "a less noisy step; many small steps beat few large ones"}),
      whole<&K::budget, &B::fit, &FitBudget::samples_per_ray>(
          "samples_per_ray", {1, kMaxSamples},
          {.unit = "samples",
           .costs = "time of a step and of a view, in proportion",
           .gives = "depth, where the camera moves"}),
      whole<&K::budget, &B::fit, &FitBudget::samples_without_parallax>(
          "samples_without_parallax", {1, kMaxSamples},
          {.unit = "samples",
           .costs = "time of a step and of a view",
           .gives = "layers where depth cannot be observed"}),
      choice<&K::budget, &B::fills>("fill", {"off", "on"},
                                    {.costs = "on: a view of the field where no frame saw a pixel unclipped",
                                     .gives = "on: there the geometric mean of the lower bound and the "
                                              "field's radiance, where that is higher"}),
      whole<&K::budget, &B::render_step>(
          "render_step", {1, 8},
          {.unit = "px",
           .costs = "more is cheaper: time of the field's view falls with its square",
           .gives = "less is sharper where the field fills unseen pixels and in its depth"}),
      choice<&K::budget, &B::shrinkage>(
          "shrinkage", {"off", "on", "dense"},
          {.costs = "time of the emission, on: about half of it; dense: that twice",
           .gives = "less noise in the output, dense: and less flicker; the state is unchanged"}),
  };
}

template <std::size_t... term>
std::vector<Knob> loss_knobs(std::index_sequence<term...>) {
  return {loss<term>()...};
}

std::vector<Knob> make_table() {
  const std::pair<KnobChange, std::vector<Knob>> groups[] = {
      {KnobChange::AtStart, stream_knobs()},
      {KnobChange::AtStart, prior_knobs()},
      {KnobChange::AtStart, field_knobs()},
      {KnobChange::AtStart, fit_knobs()},
      {KnobChange::PerFrame, frame_budget_knobs()},
      {KnobChange::AtStart, loss_knobs(std::make_index_sequence<kLossTerms>())},
  };
  std::vector<Knob> table;
  for (const auto& [change, knobs] : groups)
    for (Knob knob : knobs) {
      knob.change = change;
      table.push_back(std::move(knob));
    }
  return table;
}

}  // namespace

std::span<const Knob> knob_table() {
  static const std::vector<Knob> table = make_table();
  return table;
}

}  // namespace hdrcam
