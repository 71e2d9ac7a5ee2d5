#include "online/knobs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/core/parse_number.h"

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

struct Words {
  const char *unit, *costs, *gives;
};

template <auto... path>
Knob whole(const char* name, KnobChange change, double least, double most, Words words, int multiple = 1) {
  return {
      name,        words.unit,           KnobKind::Whole,     change, least, most, multiple, {}, words.costs,
      words.gives, &Place<path...>::get, &Place<path...>::put};
}
template <auto... path>
Knob real(const char* name, KnobChange change, double least, double most, Words words) {
  return {name,        words.unit,           KnobKind::Real,      change, least, most, 1, {}, words.costs,
          words.gives, &Place<path...>::get, &Place<path...>::put};
}
template <auto... path>
Knob choice(const char* name, KnobChange change, std::vector<std::string> choices, Words words) {
  const double most = static_cast<double>(choices.size()) - 1;
  return {name,
          words.unit,
          KnobKind::Choice,
          change,
          0,
          most,
          1,
          std::move(choices),
          words.costs,
          words.gives,
          &Place<path...>::get,
          &Place<path...>::put};
}

template <std::size_t term>
Knob loss() {
  return {std::string("loss.") + kLosses[term].name,
          "",
          KnobKind::Real,
          KnobChange::AtStart,
          0,
          100,
          1,
          {},
          "only its share of a step",
          kLosses[term].meaning,
          [](const Knobs& knobs) { return static_cast<double>(knobs.hash_grid.losses[term]); },
          [](Knobs& knobs, double value) { knobs.hash_grid.losses[term] = static_cast<float>(value); }};
}

void add_frame_budget(std::vector<Knob>& table) {
  constexpr auto kPerFrame = KnobChange::PerFrame;
  using K = Knobs;
  using B = FrameBudget;
  table.push_back(choice<&K::budget, &B::flow>(
      "flow", kPerFrame, {"coarse", "fast", "medium", "fine"},
      {"", "time of the one or two flow calls of a frame; fine takes twice as long as fast",
       "finer motion: fewer pixels lose their history"}));
  table.push_back(whole<&K::budget, &B::fit, &FitBudget::steps>(
      "steps", kPerFrame, 0, 1000,
      {"steps", "time of the fit, in proportion", "a field fitted to the frame; 0 renders the state"}));
  table.push_back(whole<&K::budget, &B::fit, &FitBudget::interval>(
      "fit_interval", kPerFrame, 1, 64,
      {"frames", "more is cheaper: the steps are taken at each n-th frame",
       "a field that follows each frame; 1 where the field itself is seen, if nothing else is said"}));
  table.push_back(whole<&K::budget, &B::fit, &FitBudget::rays_per_step>(
      "rays_per_step", kPerFrame, 32, 4096,
      {"rays", "time of a step, in proportion", "a less noisy step; many small steps beat few large ones"},
      32));
  table.push_back(whole<&K::budget, &B::fit, &FitBudget::samples_per_ray>(
      "samples_per_ray", kPerFrame, 1, kMaxSamples,
      {"samples", "time of a step and of a view, in proportion", "depth, where the camera moves"}));
  table.push_back(whole<&K::budget, &B::fit, &FitBudget::samples_without_parallax>(
      "samples_without_parallax", kPerFrame, 1, kMaxSamples,
      {"samples", "time of a step and of a view", "layers where depth cannot be observed"}));
  table.push_back(choice<&K::budget, &B::fills>(
      "fill", kPerFrame, {"off", "on"},
      {"", "on: a view of the field where no frame saw a pixel unclipped",
       "on: there the geometric mean of the lower bound and the field's radiance, where that is higher"}));
  table.push_back(whole<&K::budget, &B::render_step>(
      "render_step", kPerFrame, 1, 8,
      {"px", "more is cheaper: time of the field's view falls with its square",
       "less is sharper where the field fills unseen pixels and in its depth"}));
  table.push_back(choice<&K::budget, &B::shrinkage>(
      "shrinkage", kPerFrame, {"off", "on", "dense"},
      {"", "time of the emission, on: about half of it; dense: that twice",
       "less noise in the output, dense: and less flicker; the state is unchanged"}));
}

void add_stream(std::vector<Knob>& table) {
  constexpr auto kAtStart = KnobChange::AtStart;
  using K = Knobs;
  table.push_back(whole<&K::look_ahead>(
      "look_ahead", kAtStart, Knobs::kAsSizeAllows, 2,
      {"frames; -1: two of pictures of at most 640x480, one of larger ones, for their memory",
       "latency of as many frames, and one join for each",
       "clipped and occluded pixels that later frames show"}));
  table.push_back(whole<&K::bootstrap_frames>(
      "bootstrap_frames", kAtStart, 2, 64,
      {"frames", "latency of the first emission", "a more certain first response and black level"}));
  table.push_back(whole<&K::view_steps>(
      "view_steps", kAtStart, 0, 1000,
      {"steps", "time of the fit, in proportion",
       "takes the place of steps where the field itself is seen: its layers, --emit field, novel views"}));
  table.push_back(real<&K::code_noise>(
      "code_noise", kAtStart, 0, 20,
      {"codes rms", "nothing", "start value of the estimated compression noise: 1 clean, 2 MJPEG"}));
  table.push_back(choice<&K::noise>(
      "noise", kAtStart, {"assumed", "learned"},
      {"", "learned: about a tenth of the motion", "samples weighed by the noise they have"}));
  table.push_back(choice<&K::motion_blur>(
      "motion_blur", kAtStart, {"off", "stated", "shown"},
      {"", "a tenth of the time where things move",
       "sharp frames of what moves; stated: as exposure times say; shown: unless frames contradict it, as "
       "stills that are played as a video do"}));
  table.push_back(choice<&K::response>(
      "response", kAtStart, {"curve", "network", "mean", "linear"},
      {"", "nothing",
       "an unknown response: a curve under the prior of real cameras; for comparison a small network without "
       "one, the mean of real cameras, or none"}));
  table.push_back(real<&K::state, &StateOptions::variance_growth>(
      "state.variance_growth", kAtStart, 0, 1,
      {"per frame", "nothing", "larger values forget the past sooner"}));
  table.push_back(real<&K::state, &StateOptions::relative_growth>(
      "state.relative_growth", kAtStart, 0, 1,
      {"of radiance per frame", "nothing", "larger values follow changing light"}));
  table.push_back(real<&K::state, &StateOptions::fusion, &FusionOptions::relative_noise>(
      "state.relative_noise", kAtStart, 0, 1,
      {"of radiance", "nothing", "variance outside the noise model"}));
  table.push_back(real<&K::state, &StateOptions::fusion, &FusionOptions::blur_variance>(
      "state.blur_variance", kAtStart, 0, 1000,
      {"", "nothing", "variance of a sample per squared blur that the state predicts"}));
  table.push_back(real<&K::state, &StateOptions::fusion, &FusionOptions::misalignment>(
      "state.misalignment", kAtStart, 0, 10,
      {"of local contrast", "nothing", "variance that a warp adds; 0: none"}));
  table.push_back(real<&K::state, &StateOptions::fusion, &FusionOptions::chi2_tolerance>(
      "state.gate_tolerance", kAtStart, 0, kAny,
      {"mean chi^2", "nothing",
       "largest disagreement at which state and sample count as equal; large: no gate"}));
}

void add_priors_and_scene(std::vector<Knob>& table) {
  constexpr auto kAtStart = KnobChange::AtStart;
  using K = Knobs;
  using F = FieldOptions;
  table.push_back(
      choice<&K::pose>("pose", kAtStart, {"given", "tracked", "fixed"},
                       {"", "tracked: a few ms per frame",
                        "given: from the recording, tracked where it has none; fixed: a tripod"}));
  table.push_back(whole<&K::depth, &DepthOptions::step_px>(
      "depth_step", kAtStart, 1, 8,
      {"px", "1 costs five times as much as 2",
       "2 is as accurate as 1; where field_step is auto and nobody looks, at least twice that"}));
  table.push_back(real<&K::dynamic_depth, &DynamicDepthOptions::nearer>(
      "moving_nearer", kAtStart, 0, 10,
      {"", "1 % of the time; 0 saves it",
       "how much nearer a moving region is taken to be than what is around it, unless it stands on ground; "
       "0: not guessed"}));
  table.push_back(
      choice<&K::field>("field", kAtStart, {"none", "hash_grid"},
                        {"", "pose, depth, fit and view",
                         "depth, novel views, its motion; radiance of unseen pixels where it fills"}));
  table.push_back(choice<&K::field_step>(
      "field_step", kAtStart, {"auto", "1", "2", "4", "8"},
      {"px", "more is cheaper: memory and time of the field's passes fall with its square",
       "side of the blocks that are the field's pixels; auto: 1 where the field itself is seen, 2 to 8 where "
       "it only fills"}));
  table.push_back(whole<&K::hash_grid, &F::window, &WindowOptions::frames>(
      "window_frames", kAtStart, 2, 14,
      {"frames", "memory, 6 MB each at 320x240 and a field_step of 1",
       "motion that is smooth over the window"}));
  table.push_back(real<&K::hash_grid, &F::window, &WindowOptions::trusted_sigma>(
      "trusted_sigma", kAtStart, 0.01, 1,
      {"of ln radiance", "nothing", "sigma of the state at which networks and state have equal weight"}));
  table.push_back(real<&K::hash_grid, &F::margin>(
      "margin", kAtStart, 1, 2,
      {"", "resolution of the grids", "width of the window over the picture: allows more camera motion"}));
  table.push_back(whole<&K::hash_grid, &F::shape, &FieldShape::static_grid, &HashGridShape::log2_entries>(
      "static_entries", kAtStart, 10, 20, {"log2", "memory and cache misses", "detail of static content"}));
  table.push_back(whole<&K::hash_grid, &F::shape, &FieldShape::dynamic_grid, &HashGridShape::log2_entries>(
      "dynamic_entries", kAtStart, 10, 20, {"log2", "memory and cache misses", "detail of dynamic content"}));
  table.push_back(whole<&K::hash_grid, &F::shape, &FieldShape::static_grid, &HashGridShape::levels>(
      "static_levels", kAtStart, 1, 16, {"levels", "time of a step", "scales of static content"}));
  table.push_back(whole<&K::hash_grid, &F::shape, &FieldShape::dynamic_grid, &HashGridShape::levels>(
      "dynamic_levels", kAtStart, 1, 16, {"levels", "time of a step", "scales of dynamic content"}));
  table.push_back(whole<&K::hash_grid, &F::shape, &FieldShape::hidden>(
      "hidden", kAtStart, 4, 128,
      {"neurons", "time of a step, with its square", "capacity of the two networks"}, 4));
  table.push_back(choice<&K::hash_grid, &F::shape, &FieldShape::branches>(
      "branches", kAtStart, {"both", "static", "dynamic"},
      {"", "nothing", "static and dynamic content, or for comparison one of them alone"}));
  table.push_back(choice<&K::hash_grid, &F::shape, &FieldShape::blend>(
      "blend", kAtStart, {"density_sum", "weight"},
      {"", "nothing", "blending of static and dynamic: densities add up, or the paper's blending weight"}));
  table.push_back(real<&K::hash_grid, &F::newest_share>(
      "newest_share", kAtStart, 0, 1,
      {"", "nothing", "share of the rays in the newest frame; the rest is spread over the window"}));
  table.push_back(real<&K::hash_grid, &F::uniform_share>(
      "uniform_share", kAtStart, 0, 1,
      {"", "nothing",
       "share of uniformly drawn rays; the rest goes where the state is uncertain or the fit is bad"}));
  table.push_back(real<&K::hash_grid, &F::table_rate>("table_rate", kAtStart, 1e-5, 1,
                                                      {"", "nothing", "Adam's rate of the grids"}));
  table.push_back(real<&K::hash_grid, &F::network_rate>("network_rate", kAtStart, 1e-5, 1,
                                                        {"", "nothing", "Adam's rate of the networks"}));
  table.push_back(choice<&K::hash_grid, &F::fits_response>(
      "refine_response", kAtStart, {"off", "on"},
      {"", "about a tenth of a step", "a response refined by the photometric loss"}));
  table.push_back(real<&K::hash_grid, &F::response_rate>("response_rate", kAtStart, 0, 1e-2,
                                                         {"", "nothing", "Adam's rate of that response"}));
}

std::vector<Knob> make_table() {
  std::vector<Knob> table;
  add_stream(table);
  add_priors_and_scene(table);
  add_frame_budget(table);
  [&]<std::size_t... term>(std::index_sequence<term...>) { (table.push_back(loss<term>()), ...); }
  (std::make_index_sequence<kLossTerms>());
  return table;
}

Result<const Knob*> find_knob(std::string_view name) {
  const auto table = knob_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Knob& k) { return k.name == name; });
  if (found != table.end()) return &*found;
  std::vector<std::string_view> alike;
  for (const Knob& knob : table)
    if (!name.empty() && (knob.name.find(name) != std::string::npos || knob.name[0] == name[0]))
      alike.push_back(knob.name);
  if (alike.empty())
    for (const Knob& knob : table) alike.push_back(knob.name);
  return Error{ErrorCode::Invalid,
               fmt::format("there is no knob '{}'; there are {}", name, fmt::join(alike, ", "))};
}

}  // namespace

const char* name(Preset preset) {
  switch (preset) {
    case Preset::Realtime:
      return "realtime";
    case Preset::Fast:
      return "fast";
    case Preset::Balanced:
      return "balanced";
    case Preset::Best:
      return "best";
  }
  return "?";
}

Knobs knobs_of(Preset preset) {
  Knobs knobs;
  FitBudget& fit = knobs.budget.fit;
  switch (preset) {
    case Preset::Realtime:
      knobs = knobs_of(Preset::Fast);
      knobs.budget.flow = FlowQuality::Fast;
      knobs.budget.shrinkage = ShrinkageEffort::On;
      knobs.field = FieldKind::None;
      break;
    case Preset::Fast:
      knobs.budget.render_step = 4;
      fit.steps = 1, fit.interval = 4, fit.samples_per_ray = 6, fit.samples_without_parallax = 1;
      knobs.view_steps = 10;
      knobs.hash_grid.shape.static_grid.log2_entries = 14;
      knobs.hash_grid.shape.dynamic_grid.log2_entries = 12;
      break;
    case Preset::Balanced:
      knobs.budget.flow = FlowQuality::Fine;
      knobs.look_ahead = Knobs::kAsSizeAllows;
      fit.steps = 1, fit.interval = 4;
      break;
    case Preset::Best:
      knobs.budget.flow = FlowQuality::Fine;
      knobs.budget.render_step = 1;
      knobs.look_ahead = 2;
      fit.steps = 1, fit.interval = 2;
      knobs.view_steps = 100;
      break;
  }
  return knobs;
}

int look_ahead_of(const Knobs& knobs, int rows, int cols) {
  constexpr std::int64_t kSmall = 640 * 480;  // pixels
  if (knobs.look_ahead != Knobs::kAsSizeAllows) return knobs.look_ahead;
  return static_cast<std::int64_t>(rows) * cols <= kSmall ? 2 : 1;
}

std::span<const Knob> knob_table() {
  static const std::vector<Knob> table = make_table();
  return table;
}

std::string accepted_values(const Knob& knob) {
  if (knob.kind == KnobKind::Choice) return fmt::format("{}", fmt::join(knob.choices, ", "));
  std::string text = fmt::format(
      "{}, {:g}..{:g}", knob.kind == KnobKind::Whole ? "a whole number" : "a number", knob.least, knob.most);
  if (*knob.unit != '\0') text += fmt::format(" {}", knob.unit);
  if (knob.multiple > 1) text += fmt::format(", a multiple of {}", knob.multiple);
  return text;
}

Result<std::string> knob_value(const Knobs& knobs, std::string_view name) {
  const Knob& knob = *TRY(find_knob(name));
  const double value = knob.get(knobs);
  if (knob.kind == KnobKind::Choice) return knob.choices[static_cast<std::size_t>(value)];
  return fmt::format("{}", static_cast<float>(value));
}

Result<void> set_knob(Knobs& knobs, std::string_view name, std::string_view text) {
  const Knob& knob = *TRY(find_knob(name));
  const auto refuse = [&] {
    return Error{ErrorCode::Invalid,
                 fmt::format("{} takes {}, not '{}'", knob.name, accepted_values(knob), text)};
  };
  if (knob.kind == KnobKind::Choice) {
    const auto found = std::find(knob.choices.begin(), knob.choices.end(), text);
    if (found == knob.choices.end()) return refuse();
    knob.put(knobs, static_cast<double>(found - knob.choices.begin()));
    return {};
  }
  const auto value = parse_number<double>(text);
  if (!value || *value < knob.least || *value > knob.most) return refuse();
  if (knob.kind == KnobKind::Whole && std::fmod(*value, knob.multiple) != 0) return refuse();
  knob.put(knobs, *value);
  return {};
}

Result<void> set_knob(Knobs& knobs, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos)
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' has no value; write NAME=VALUE, such as steps=100", assignment)};
  return set_knob(knobs, assignment.substr(0, equals), assignment.substr(equals + 1));
}

}  // namespace hdrcam
