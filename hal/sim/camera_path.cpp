#include "hal/sim/camera_path.h"

#include <numbers>

#include "hal/sim/counter_random.h"

namespace hdrcam {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::uint64_t kPathStream = 0x70617468;
constexpr CameraMove kMoves[] = {CameraMove::Still, CameraMove::Handheld, CameraMove::Pan, CameraMove::Dolly,
                                 CameraMove::Orbit};

float wave(double frequency_hz, double time_s) {
  return static_cast<float>(std::sin(kTurn * frequency_hz * time_s));
}

// Amplitudes of a move at speed 1. Places in scene sizes, angles in radians.
struct Amplitudes {
  Vec3 swing;  // slow, smooth motion
  Vec3 swing_hz;
  float pan = 0, pan_hz = 0;
  float shake = 0;   // tremble of the position
  float shiver = 0;  // tremble of the direction
};
Amplitudes amplitudes(CameraMove move) {
  switch (move) {
    case CameraMove::Still:
      return {};
    case CameraMove::Handheld:
      return {{0.03f, 0.008f, 0}, {0.35f, 0.5f, 0}, 0, 0, 0.0075f, 0.012f};
    case CameraMove::Pan:
      return {{}, {}, 0.7f, 0.06f, 0, 0};  // pure rotation, up to 0.26 rad/s
    case CameraMove::Dolly:
      return {{0.04f, 0, 0.35f}, {0.05f, 0, 0.04f}, 0, 0, 0.002f, 0.003f};
    case CameraMove::Orbit:
      return {{0.15f, 0.025f, 0.025f}, {0.22f, 0.3f, 0.22f}, 0, 0, 0.0015f, 0.001f};
  }
  return {};
}

// Looks from `place` at `target`, upright.
Mat3 looking_at(Vec3 place, Vec3 target) {
  const Vec3 z = normalized(target - place);
  const Vec3 x = normalized(cross({0, 1, 0}, z));
  return {x, cross(z, x), z};
}

}  // namespace

const char* name(CameraMove move) {
  switch (move) {
    case CameraMove::Still:
      return "still";
    case CameraMove::Handheld:
      return "handheld";
    case CameraMove::Pan:
      return "pan";
    case CameraMove::Dolly:
      return "dolly";
    case CameraMove::Orbit:
      return "orbit";
  }
  return "?";
}

std::optional<CameraMove> camera_move_of(std::string_view wanted) {
  for (const CameraMove move : kMoves)
    if (wanted == name(move)) return move;
  return std::nullopt;
}

float CameraPath::Tremble::at(double time_s) const {
  constexpr double kMost = 1 + 0.5 + 1.0 / 3;  // of the waves, each of which has 1 / its number
  double sum = 0;
  for (std::size_t i = 0; i < frequency_hz.size(); ++i)
    sum += std::sin(kTurn * frequency_hz[i] * time_s + phase_rad[i]) / static_cast<double>(1 + i);
  return static_cast<float>(sum / kMost);
}

CameraPath::CameraPath(CameraMove move, std::uint64_t seed, float scale_m, float speed)
    : move_(move), scale_(scale_m), speed_(speed) {
  for (std::size_t i = 0; i < trembles_.size(); ++i) {
    const CounterRandom random(seed, kPathStream, i);
    for (std::size_t k = 0; k < 3; ++k) {
      trembles_[i].frequency_hz[k] = random.uniform(2 * k, 0.6f, 4.2f);
      trembles_[i].phase_rad[k] = random.uniform(2 * k + 1) * kTurn;
    }
  }
}

Pose CameraPath::at(double time_s) const {
  const Amplitudes a = amplitudes(move_);
  const auto tremble = [&](std::size_t i, float amplitude) {
    return amplitude == 0 ? 0.f : amplitude * speed_ * trembles_[i].at(time_s);
  };
  Vec3 place = Vec3{a.swing.x * wave(a.swing_hz.x, time_s), a.swing.y * wave(a.swing_hz.y, time_s),
                    a.swing.z * wave(a.swing_hz.z, time_s)} *
               speed_;
  place = place + Vec3{tremble(0, a.shake), tremble(1, a.shake), tremble(2, 0.6f * a.shake)};
  place = place * scale_;
  const float yaw = speed_ * a.pan * wave(a.pan_hz, time_s) + tremble(3, a.shiver);
  const Mat3 shiver = rotation({0, 1, 0}, yaw) * rotation({1, 0, 0}, tremble(4, a.shiver)) *
                      rotation({0, 0, 1}, tremble(5, 0.5f * a.shiver));
  return {looking_at(place, {0, 0, scale_}) * shiver, place};
}

}  // namespace hdrcam
