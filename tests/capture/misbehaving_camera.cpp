#include "tests/capture/misbehaving_camera.h"

#include <algorithm>
#include <cmath>

namespace hdrcam::test {
namespace {

constexpr int kTexture = 512;
constexpr float kRawBlack = 64;  // of 1023

// Radiance of a large scene, periodic: value noise of five octaves, its logarithm about 2 wide.
std::vector<float> make_texture(std::mt19937& random) {
  std::normal_distribution<float> normal;
  std::vector<float> texture(kTexture * kTexture, 0.f);
  for (int octave = 0; octave < 5; ++octave) {
    const int cells = 8 << octave, size = kTexture / cells;
    std::vector<float> lattice(static_cast<std::size_t>(cells * cells));
    for (float& v : lattice) v = normal(random) * 1.5f / static_cast<float>(1 + octave);
    const auto node = [&](int y, int x) {
      return lattice[static_cast<std::size_t>(y % cells * cells + x % cells)];
    };
    for (int y = 0; y < kTexture; ++y) {
      for (int x = 0; x < kTexture; ++x) {
        const int j = y / size, i = x / size;
        const float v = static_cast<float>(y % size) / static_cast<float>(size);
        const float u = static_cast<float>(x % size) / static_cast<float>(size);
        texture[static_cast<std::size_t>(y * kTexture + x)] +=
            (1 - v) * ((1 - u) * node(j, i) + u * node(j, i + 1)) +
            v * ((1 - u) * node(j + 1, i) + u * node(j + 1, i + 1));
      }
    }
  }
  for (float& v : texture) v = std::exp(v);
  return texture;
}

}  // namespace

MisbehavingCamera::MisbehavingCamera(const SensorSettings& settings, const SensorFaults& faults)
    : settings_(settings), faults_(faults), random_(settings.seed), texture_(make_texture(random_)) {
  std::normal_distribution<float> normal;
  noise_.resize(1 << 16);
  for (float& v : noise_) v = normal(random_);
  row_.resize(static_cast<std::size_t>(settings.width));
  values_.resize(1 << 15);
  for (std::size_t i = 0; i < values_.size(); ++i)
    values_[i] = value_of(static_cast<float>(i) / static_cast<float>(values_.size() - 1));
  capabilities_.id = "model";
  const bool in_table = settings.kind == SensorKind::RawBayer10 && !settings.states_black;
  capabilities_.model = in_table ? "imx219" : "webcam";
  capabilities_.exposure_min = Duration(10'000);
  capabilities_.exposure_max = Duration(33'000'000);
  capabilities_.exposure_step = Duration(10'000);
  capabilities_.gain_min = settings.least_gain, capabilities_.gain_max = 16;
  capabilities_.sets_exposure = true;
  capabilities_.reports_exposure = settings.reports;
  capabilities_.exposure_per_request = settings.per_request;
}

bool MisbehavingCamera::happens(double probability) {
  return probability > 0 && std::uniform_real_distribution<>()(random_) < probability;
}

Result<StreamMode> MisbehavingCamera::configure(const StreamMode&, int buffers) {
  buffers_ = buffers;
  mode_ = {settings_.kind == SensorKind::RawBayer10 ? PixelFormat::Rggb10 : PixelFormat::Grey8,
           settings_.width, settings_.height, kFrame};
  const std::size_t bytes = settings_.kind == SensorKind::RawBayer10 ? 2 : 1;
  pixels_.resize(bytes * static_cast<std::size_t>(settings_.width) *
                 static_cast<std::size_t>(settings_.height));
  return mode_;
}

Result<void> MisbehavingCamera::start() {
  running_ = true;
  queued_.clear();
  clock_ = Instant::from_seconds(100);
  schedule_of_frame_.assign(1, Controls{});
  return {};
}

Result<void> MisbehavingCamera::stop() {
  running_ = false;
  return {};
}

void MisbehavingCamera::give_back(int) { --leased_; }

Result<void> MisbehavingCamera::queue(const ExposureRequest& request) {
  if (static_cast<int>(queued_.size()) + leased_ >= buffers_)
    return Error{ErrorCode::Busy, "all buffers of the model are queued"};
  queued_.push_back(request);
  history_.push_back(request);
  if (history_.size() > 64) history_.pop_front(), ++first_in_history_;
  return {};
}

// The request at the head of the queue has its turn as frame `frame_` begins, or is too late for it.
void MisbehavingCamera::write_controls(const ExposureRequest& request, bool late) {
  const auto write = [&](int latency, auto&& set) {
    const std::size_t from = frame_ + static_cast<std::size_t>(latency) + (late ? 1 : 0);
    while (schedule_of_frame_.size() <= from) schedule_of_frame_.push_back(schedule_of_frame_.back());
    for (std::size_t i = from; i < schedule_of_frame_.size(); ++i) set(schedule_of_frame_[i]);
  };
  write(settings_.latency, [&](Controls& c) { c.time = request.exposure; });
  write(settings_.gain_latency, [&](Controls& c) { c.gain = request.analogue_gain; });
}

// What the sensor does in frame `frame_`, which completes request number `request`.
MisbehavingCamera::Controls MisbehavingCamera::applied(std::size_t request) {
  const auto of_request = [&](std::int64_t number) {
    const auto index = std::clamp<std::int64_t>(number - static_cast<std::int64_t>(first_in_history_), 0,
                                                static_cast<std::int64_t>(history_.size()) - 1);
    return asked_for(history_[static_cast<std::size_t>(index)]);
  };
  const auto of_frame = [&](std::int64_t frame) {
    const auto index =
        std::clamp<std::int64_t>(frame, 0, static_cast<std::int64_t>(schedule_of_frame_.size()) - 1);
    return schedule_of_frame_[static_cast<std::size_t>(index)];
  };
  std::int64_t off = slipped_;
  if (happens(faults_.exposure_late)) off -= 1;
  if (happens(faults_.exposure_early)) off += 1;
  if (happens(faults_.slip)) ++slipped_;
  Controls controls = settings_.per_request ? of_request(static_cast<std::int64_t>(request) + off)
                                            : of_frame(static_cast<std::int64_t>(frame_) + off);
  if (!first_) first_ = controls;
  if (faults_.never_applied) controls = *first_;
  if (faults_.clips_always || happens(faults_.exposure_clipped))
    controls.time = std::min(controls.time, faults_.clip_time);
  return controls;
}

void MisbehavingCamera::expose_frame(const Controls& controls, Instant begin) {
  std::normal_distribution<> normal;
  light_ += settings_.light_walk * normal(random_);
  light_ *= 0.999;
  scene_x_ += settings_.pan_px;
  scene_y_ += settings_.pan_px * 0.3;
  if (happens(settings_.cut)) {
    scene_x_ += 211, scene_y_ += 97;
    light_ = normal(random_);
  }
  if (happens(faults_.strobe_lost)) {
    edge_sequence_ += 2;
    return;
  }
  const Instant rise = begin + settings_.strobe_offset;
  edges_.push_back({rise, true, edge_sequence_++});
  edges_.push_back({rise + controls.time + Duration(15'000), false, edge_sequence_++});
}

// Radiance of a row of the picture, without the light's own walk.
void MisbehavingCamera::light_row(int y, std::vector<float>& row) const {
  const auto wrap = [](double v) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(v) & (kTexture - 1));
  };
  const float* texture = texture_.data() + wrap(y + scene_y_) * kTexture;
  for (int x = 0; x < settings_.width; ++x) row[static_cast<std::size_t>(x)] = texture[wrap(x + scene_x_)];
  if (!settings_.object) return;
  const double cx = std::fmod(7.0 * static_cast<double>(frame_), settings_.width + 60.0) - 30,
               dy = y - settings_.height * 0.6;
  const double half = std::sqrt(std::max(0.0, 400 - dy * dy));
  for (int x = std::max(0, static_cast<int>(cx - half)); x < std::min<double>(settings_.width, cx + half);
       ++x)
    row[static_cast<std::size_t>(x)] = 4.5f;
}

float MisbehavingCamera::value_of(float x) const {
  switch (settings_.kind) {
    case SensorKind::RawBayer10:
      return x;
    case SensorKind::Gamma8:
      return std::pow(x, 1 / 2.2f);
    case SensorKind::Film8:
      break;
  }
  const float u = std::pow(x, 0.8f);  // a toe and a shoulder, off any power law
  return u * 1.25f / (u + 0.25f);
}

void MisbehavingCamera::paint(double product) {
  const auto scale = static_cast<float>(settings_.key * std::exp(light_) * product / 4e-3 * 0.25);
  const bool raw = settings_.kind == SensorKind::RawBayer10;
  const float black = raw ? kRawBlack : 0, most = raw ? 1023 : 255;
  std::size_t noise = random_() & 0xffff, out = 0;
  for (int y = 0; y < settings_.height; ++y) {
    light_row(y, row_);
    for (int x = 0; x < settings_.width; ++x) {
      float light = row_[static_cast<std::size_t>(x)] * scale;
      if (raw && (x & 1) == (y & 1)) light *= (x & 1) != 0 ? 0.6f : 0.7f;
      light += noise_[noise++ & 0xffff] * std::sqrt(light / 5000 + 4e-6f);
      const float value = values_[static_cast<std::size_t>(std::clamp(light, 0.f, 1.f) *
                                                           static_cast<float>(values_.size() - 1))];
      const auto code = static_cast<unsigned>(black + value * (most - black) + 0.5f);
      pixels_[out++] = static_cast<std::byte>(code & 255u);
      if (raw) pixels_[out++] = static_cast<std::byte>(code >> 8);
    }
  }
}

Result<CapturedBuffer> MisbehavingCamera::wait(Duration) {
  if (!running_) return Error{ErrorCode::Interrupted, "the model was stopped"};
  if (queued_.empty()) return Error{ErrorCode::Timeout, "no request is queued"};
  std::normal_distribution<> normal;
  const int lost = happens(faults_.drop) ? faults_.drop_run : 0;
  const bool late = happens(faults_.written_late);
  Controls controls;
  for (int i = 0; i <= lost; ++i) {
    write_controls(queued_.front(), late && i == 0);
    // The exposure of a lost frame is spent on it when controls go by frames; a request waits for a frame
    // that comes.
    if (i == lost || !settings_.per_request) controls = applied(completed_);
    expose_frame(controls, clock_);
    ++frame_;
    if (i == lost || !faults_.hide_drops) ++sequence_;
    if (i == lost || !faults_.freeze_time) clock_ = clock_ + settings_.kept_frame;
  }
  truth_ = log_product({controls.time, controls.gain});
  paint(std::exp(truth_));

  CapturedBuffer buffer;
  buffer.cookie = queued_.front().cookie;
  queued_.pop_front();
  ++completed_;
  if (completed_ > 1 && happens(faults_.cookie_doubled)) buffer.cookie = last_cookie_;
  last_cookie_ = buffer.cookie;
  buffer.sequence = sequence_;
  buffer.timestamp =
      clock_ + (-settings_.kept_frame + Duration(static_cast<Duration::rep>(5e4 * normal(random_))));
  buffer.damaged = happens(faults_.damage);
  buffer.control_late = late;
  if (settings_.reports && !happens(faults_.report_missing)) {
    const Controls& told = before_ && happens(faults_.report_late) ? *before_ : controls;
    buffer.exposure = told.time;
    buffer.analogue_gain = told.gain;
    if (settings_.embedded) buffer.exposure_source = ExposureSource::Embedded;
  }
  before_ = controls;
  if (settings_.states_black) buffer.black_level = BlackLevel::of_code(kRawBlack, 10);
  buffer.mode = mode_;
  buffer.pixels = pixels_;
  ++leased_;
  buffer.lease = BufferLease(*this, 0);
  return buffer;
}

Result<Edge> StrobeModel::wait_edge(Duration) {
  if (sensor_.edges().empty()) return Error{ErrorCode::Timeout, "no edge"};
  const Edge edge = sensor_.edges().front();
  sensor_.edges().pop_front();
  return edge;
}

}  // namespace hdrcam::test
