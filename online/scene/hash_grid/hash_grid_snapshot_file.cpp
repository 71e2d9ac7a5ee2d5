// A snapshot of a hash grid field as sections of a file (docs/snapshot.md): what look() reads, and nothing
// that only a fit needs.
#include <algorithm>
#include <cmath>

#include "hal/core/possible_pose.h"
#include "hal/sections/fact_fields.h"
#include "online/scene/hash_grid/hash_grid_field.h"

namespace hdrcam {

template <Either<WindowFrustum> Frustum>
void list_fields(auto& fields, Frustum& frustum) {
  fields(frustum.camera, frustum.rows, frustum.cols, frustum.margin, frustum.near, frustum.step_px);
}

template <Either<HashGridShape> Shape>
void list_fields(auto& fields, Shape& shape) {
  fields(shape.levels, shape.log2_entries, shape.slots, shape.coarsest_cells, shape.finest_cells,
         shape.v_ratio, shape.d_ratio);
}

namespace {

constexpr int kMostFrames = WindowOptions::kMostFrames, kMostHidden = 256;
constexpr std::string_view kBase = "field frame", kNetworks = "field networks";

struct StoredFrame {
  int slot = 0;
  double time_s = 0;
  RigidTransform T_anchor_camera;
};

struct StoredField {
  WindowFrustum frustum;
  RigidTransform T_world_anchor;
  std::vector<StoredFrame> frames;
  FieldShape shape;
  int samples_per_ray = 1;
  bool has_dynamic = false;
};

template <Either<StoredFrame> Frame>
void list_fields(auto& fields, Frame& frame) {
  fields(frame.slot, frame.time_s, frame.T_anchor_camera);
}

template <Either<StoredField> Field>
void list_fields(auto& fields, Field& field) {
  fields(field.frustum, field.T_world_anchor, field.frames, field.shape.static_grid, field.shape.dynamic_grid,
         field.shape.hidden);
  fields.word(field.shape.blend, Blend::Weight);
  fields(field.samples_per_ray, field.has_dynamic);
}

bool is_possible(const WindowFrustum& frustum) {
  const int step = frustum.step_px;
  const Intrinsics& lens = frustum.camera;
  const Intrinsics of_stream{step * lens.fx_px, step * lens.fy_px, step * lens.cx_px, step * lens.cy_px};
  return (step == 1 || step == 2 || step == 4 || step == 8) && is_within(frustum.rows, 1, kMaxSidePx) &&
         is_within(frustum.cols, 1, kMaxSidePx) &&
         !objection_to(of_stream, step * frustum.cols, step * frustum.rows) &&
         is_within(static_cast<double>(frustum.margin), 1, 2) &&
         is_within(static_cast<double>(frustum.near), 1e-9, 1e9);
}

bool is_possible(const HashGridShape& shape) {
  return is_within(shape.levels, 2, HashGridShape::kMostLevels) && shape.levels % 2 == 0 &&
         is_within(shape.log2_entries, HashGridShape::kFewestLog2Entries, HashGridShape::kMostLog2Entries) &&
         is_within(shape.slots, 1, kMostFrames + 1) && is_within(shape.coarsest_cells, 2, 1 << 16) &&
         is_within(shape.finest_cells, shape.coarsest_cells, 1 << 16) &&
         is_within(static_cast<double>(shape.v_ratio), 1.0 / kMaxSidePx, kMaxSidePx) &&
         is_within(static_cast<double>(shape.d_ratio), 1e-3, 1e3);
}

bool is_possible(const StoredField& field) {
  const FieldShape& shape = field.shape;
  if (!is_possible(field.frustum) || !is_possible_pose(field.T_world_anchor) ||
      !is_possible(shape.static_grid) || !is_possible(shape.dynamic_grid))
    return false;
  if (!is_within(shape.hidden, 4, kMostHidden) || shape.hidden % 4 != 0) return false;
  if (!is_within(field.samples_per_ray, 1, kMaxSamples)) return false;
  if (field.frames.empty() || field.frames.size() > kMostFrames) return false;
  for (std::size_t i = 0; i < field.frames.size(); ++i) {
    const StoredFrame& frame = field.frames[i];
    if (!is_within(frame.slot, 0, shape.dynamic_grid.slots - 1) || !std::isfinite(frame.time_s) ||
        !is_possible_pose(frame.T_anchor_camera) || (i > 0 && frame.time_s <= field.frames[i - 1].time_s))
      return false;
  }
  return true;
}

// Of a branch's table and network.
std::uint64_t numbers_in(const HashGridShape& grid, int hidden, int outputs) {
  const auto inputs = static_cast<std::uint64_t>(grid.levels * HashGrid<float>::kFeatures);
  const auto h = static_cast<std::uint64_t>(hidden), out = static_cast<std::uint64_t>(outputs);
  return inputs * static_cast<std::uint64_t>(grid.slots) * (std::uint64_t{1} << grid.log2_entries) +
         (inputs + 1) * h + (h + 1) * h + (h + 1) * out;
}

// What a fit makes is far below; what is far above overflows where rays are followed.
bool are_usual(std::span<const float> values) {
  constexpr float kMost = 1e4f;
  return std::ranges::all_of(values, [](float value) { return std::abs(value) <= kMost; });
}

bool is_usual(const BasePixel& pixel) {
  constexpr std::size_t kShifts = 4;
  const std::span<const float> all = pixel, shifts = all.subspan(kBaseFlow, kShifts);
  return are_usual(all.first(kBaseFlow)) && are_usual(all.subspan(kBaseFlow + kShifts)) &&
         std::ranges::all_of(shifts, [](float shift) { return std::abs(shift) <= kMostShift; });
}

Result<void> load_base(SectionReader& file, const WindowFrustum& frustum, Image<BasePixel>& base) {
  TRY(file.begin(kBase));
  const std::uint64_t pixels = pixel_count(frustum.rows, frustum.cols);
  if (file.length() != pixels * sizeof(BasePixel)) return file.wrong("it is not as large as its frame");
  base.reshape(1, frustum.rows, frustum.cols);
  TRY(file.read(std::as_writable_bytes(base.samples())));
  TRY(file.end());
  if (!std::ranges::all_of(base.samples(), is_usual)) return file.wrong("it holds a value that no field has");
  return {};
}

Result<FieldNetworks<float>> load_networks(SectionReader& file, const FieldShape& shape) {
  TRY(file.begin(kNetworks));
  const std::uint64_t numbers = numbers_in(shape.static_grid, shape.hidden, StaticHead::kCount) +
                                numbers_in(shape.dynamic_grid, shape.hidden, DynamicHead::kCount);
  if (file.length() != numbers * sizeof(float)) return file.wrong("it is not as large as its networks");
  Pcg32 random(1);
  FieldNetworks<float> networks(shape, random);
  bool usual = true;
  for (Branch<float>* branch : {&networks.static_, &networks.dynamic})
    for (const std::span<float> values : {branch->grid.tables().samples(), branch->mlp.parameters()}) {
      TRY(file.read(std::as_writable_bytes(values)));
      usual = usual && are_usual(values);
    }
  TRY(file.end());
  if (!usual) return file.wrong("it holds a value that no field has");
  return networks;
}

}  // namespace

Result<void> HashGridSnapshot::save(SectionWriter& file) const {
  StoredField field{.frustum = window_.frustum(),
                    .T_world_anchor = window_.T_world_anchor(),
                    .frames = {},
                    .shape = {.static_grid = networks_.static_.grid.shape(),
                              .dynamic_grid = networks_.dynamic.grid.shape(),
                              .hidden = networks_.static_.mlp.hidden(),
                              .blend = networks_.blend},
                    .samples_per_ray = samples_per_ray_,
                    .has_dynamic = has_dynamic_};
  for (int i = 0; i < window_.size(); ++i)
    field.frames.push_back(
        {window_.frame(i).slot, window_.frame(i).time_s, window_.frame(i).T_anchor_camera});
  FieldsOut fields;
  fields(field);
  TRY(file.add(kSection, fields.bytes()));
  for (int i = 0; i < window_.size(); ++i)
    TRY(file.add(kBase, std::as_bytes(window_.frame(i).base.samples())));
  std::vector<Bytes> parts;
  for (const Branch<float>* branch : {&networks_.static_, &networks_.dynamic}) {
    parts.push_back(std::as_bytes(branch->grid.tables().samples()));
    parts.push_back(std::as_bytes(branch->mlp.parameters()));
  }
  return file.add(kNetworks, parts);
}

Result<std::unique_ptr<FieldSnapshot>> HashGridSnapshot::load(SectionReader& file, GpuDevice* gpu) {
  StoredField stored;
  TRY(file.read_fields(stored));
  if (!is_possible(stored)) return file.wrong("it holds values that no field has");
  std::vector<std::unique_ptr<WindowFrame>> frames;
  std::vector<WindowFrame*> order;
  for (const StoredFrame& of : stored.frames) {
    WindowFrame& frame = *frames.emplace_back(std::make_unique<WindowFrame>());
    order.push_back(&frame);
    frame.slot = of.slot, frame.time_s = of.time_s, frame.T_anchor_camera = of.T_anchor_camera;
    TRY(load_base(file, stored.frustum, frame.base));
  }
  auto networks = TRY(load_networks(file, stored.shape));
  // private to this class
  std::unique_ptr<HashGridSnapshot> snapshot(
      new HashGridSnapshot(std::move(frames), {stored.frustum, stored.T_world_anchor, std::move(order)},
                           std::move(networks), gpu));
  snapshot->samples_per_ray_ = stored.samples_per_ray;
  snapshot->has_dynamic_ = stored.has_dynamic;
  return std::unique_ptr<FieldSnapshot>(std::move(snapshot));
}

}  // namespace hdrcam
