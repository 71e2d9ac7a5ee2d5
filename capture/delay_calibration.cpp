#include "capture/delay_calibration.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "capture/control_latency.h"
#include "capture/drop_streak.h"
#include "capture/photometry.h"

namespace hdrcam {
namespace {

// Which delay the pictures show, of a pattern of two exposures.
class DelayCalibration {
 public:
  static constexpr int kEnough = 16;  // comparisons

  // Two exposures at least a stop apart; they differ in the control to be measured, time or gain.
  DelayCalibration(const Exposure& shorter, const Exposure& longer, const PhotometricResponse& response);

  // The exposure for the next request.
  Exposure next();
  // Frame `index` arrived (lost frames count); `asked` is the exposure requested for the frame after it.
  void observe(std::uint64_t index, const PhotometricSignature& picture, const Exposure& asked);
  // What observe() does with `asked`; alone for a frame whose picture cannot be read, which used up its
  // request as any other.
  void note_request(std::uint64_t index, const Exposure& asked);
  // Before either: the exposure requested for the frame that arrived was written late or never. Which
  // exposure the frame shows that should show it is unknown, whatever the delay.
  void written_late() { asked_[newest_ % kHistory].reset(); }

  DelayEstimate estimate() const;
  const Photometer& photometer() const { return photometer_; }

 private:
  static constexpr int kHistory = 64;
  // 1 for the longer exposure, 0 for the shorter, nullopt where no request is known.
  std::optional<int> asked_during(std::uint64_t index, int delay) const;

  std::array<Exposure, 2> exposures_;
  double log_step_;
  Photometer photometer_;
  unsigned register_ = 1;
  std::array<std::optional<int>, kHistory> asked_{};
  std::uint64_t newest_ = 0;
  std::optional<PhotometricSignature> last_picture_;
  std::uint64_t last_index_ = 0;
  std::array<int, kMaxDelay + 1> hits_{}, misses_{};
};

DelayCalibration::DelayCalibration(const Exposure& shorter, const Exposure& longer,
                                   const PhotometricResponse& response)
    : exposures_{shorter, longer},
      log_step_(log_product(longer) - log_product(shorter)),
      photometer_(response) {
  constexpr double kRounding = 0.004;  // of exposures to what the sensor can do
  HDRCAM_CHECK_LE(std::numbers::ln2 - kRounding, log_step_);
}

// The shift register of x^5 + x^2 + 1.
Exposure DelayCalibration::next() {
  const unsigned bit = register_ & 1u;
  register_ = register_ >> 1 | ((register_ ^ register_ >> 2) & 1u) << 4;
  return exposures_[bit];
}

std::optional<int> DelayCalibration::asked_during(std::uint64_t index, int delay) const {
  const auto back = static_cast<std::uint64_t>(delay);
  if (index < back || newest_ - (index - back) >= kHistory) return std::nullopt;
  return asked_[(index - back) % kHistory];
}

void DelayCalibration::observe(std::uint64_t index, const PhotometricSignature& picture,
                               const Exposure& asked) {
  if (last_picture_ && index > last_index_) {
    const auto ratio = photometer_.ratio(*last_picture_, picture);
    const bool tells = ratio && !(ratio->allows(-log_step_) && ratio->allows(0) && ratio->allows(log_step_));
    for (int delay = 0; tells && delay <= kMaxDelay; ++delay) {
      const auto now = asked_during(index, delay), before = asked_during(last_index_, delay);
      if (!now || !before) continue;
      auto& count = ratio->allows((*now - *before) * log_step_) ? hits_ : misses_;
      ++count[static_cast<std::size_t>(delay)];
    }
  }
  last_picture_ = picture;
  last_index_ = index;
  note_request(index, asked);
}

void DelayCalibration::note_request(std::uint64_t index, const Exposure& asked) {
  // A lost frame does not use up its request: the next frame takes it.
  const std::uint64_t during = index + 1;
  for (std::uint64_t lost = newest_ + 1; lost < during && lost <= newest_ + kHistory; ++lost)
    asked_[lost % kHistory] = asked_[newest_ % kHistory];
  asked_[during % kHistory] = asked == exposures_[1] ? 1 : 0;
  newest_ = during;
}

DelayEstimate DelayCalibration::estimate() const {
  // Scene changes and chance make this share of comparisons wrong; a wrong delay disagrees with about half of
  // them.
  constexpr double kWrong = 0.1, kMostMisses = 0.2, kSure = 0.9999;
  std::array<double, kMaxDelay + 1> log_likelihood{};
  for (std::size_t d = 0; d < log_likelihood.size(); ++d) {
    // A longer delay has fewer comparisons and is judged by its share of hits.
    const int compared = hits_[d] + misses_[d];
    const double share = compared > 0 ? static_cast<double>(misses_[d]) / compared : 1;
    const double weight = static_cast<double>(hits_[0] + misses_[0]);
    log_likelihood[d] = weight * (share * std::log(kWrong) + (1 - share) * std::log(1 - kWrong));
  }
  const auto best = static_cast<std::size_t>(std::max_element(log_likelihood.begin(), log_likelihood.end()) -
                                             log_likelihood.begin());
  const double evidence =
      std::accumulate(log_likelihood.begin(), log_likelihood.end(), 0.0,
                      [&](double sum, double l) { return sum + std::exp(l - log_likelihood[best]); });

  DelayEstimate estimate;
  estimate.comparisons = hits_[best] + misses_[best];
  estimate.confidence = 1 / evidence;
  estimate.agreed = hits_[best];
  if (estimate.comparisons < kEnough) {
    estimate.reason = fmt::format(
        "only {} of the {} required comparisons were possible: the scene is too dark, clipped "
        "or unsteady, frames are lost, or exposures are written late",
        estimate.comparisons, int{kEnough});
  } else if (1 - estimate.agreement() > kMostMisses) {
    // Rounded up, or a delay would explain more than is said.
    const int most_percent = (100 * estimate.agreed + estimate.comparisons - 1) / estimate.comparisons;
    estimate.reason = fmt::format(
        "no delay explains more than {} % of the pictures: the camera may ignore the control, or adjust "
        "itself",
        most_percent);
  } else if (estimate.confidence < kSure) {
    estimate.reason = "two delays explain the pictures equally well";
  } else {
    estimate.delay = static_cast<int>(best);
  }
  return estimate;
}

// The requests of a measurement, in order, each with its exposure.
class CalibrationRequests {
 public:
  CalibrationRequests(Camera& camera, DelayCalibration& calibration)
      : camera_(camera), calibration_(calibration) {}

  // Returns whether there was a free buffer: a device may have fewer than requested. If not, the exposure
  // waits.
  Result<bool> queue_next() {
    if (!pending_) pending_ = calibration_.next();
    const Result<void> queued = camera_.queue({cookie_, pending_->time, pending_->gain});
    if (!queued && queued.error().code == ErrorCode::Busy) return false;
    if (!queued) return queued.error();
    asked_[cookie_++ % kAsked] = *pending_;
    pending_.reset();
    return true;
  }
  // The exposure that was requested after the one with this cookie.
  const Exposure& after(std::uint64_t cookie) const { return asked_[(cookie + 1) % kAsked]; }

 private:
  static constexpr std::size_t kAsked = 64;

  Camera& camera_;
  DelayCalibration& calibration_;
  std::array<Exposure, kAsked> asked_{};  // by cookie
  std::uint64_t cookie_ = 0;
  std::optional<Exposure> pending_;
};

// Shows the calibration the pictures of a camera that is started.
Result<void> observe_pictures(Camera& camera, const DelayMeasurement& how, const std::atomic<bool>& stop,
                              DelayCalibration& calibration) {
  constexpr int kFrames = 10;  // that a camera may leave out or take for its start
  const Duration patience = std::max<Duration>(std::chrono::seconds(2), kFrames * how.mode.frame_duration);
  const PixelCodes kind = codes_of(how.mode.format);
  const std::uint64_t last_index = 2 * static_cast<std::uint64_t>(how.frames);
  const std::string& id = camera.capabilities().id;
  CalibrationRequests requests(camera, calibration);
  DropStreak drops;
  PhotometricSignature picture;
  Image<std::uint16_t> codes;
  std::uint64_t index = 0, sequence = 0;
  for (int i = 0; i < how.buffers && TRY(requests.queue_next()); ++i) continue;
  for (int i = 0; i < how.frames && index < last_index; ++i) {
    if (stop) return Error{ErrorCode::Interrupted, "stopped before the delay was measured"};
    bool readable = false;
    std::uint64_t completed = 0;
    {
      const CapturedBuffer buffer = TRY(camera.wait(patience));
      if (i > 0) index += buffer.sequence > sequence ? buffer.sequence - sequence : 1;
      sequence = buffer.sequence;
      completed = buffer.cookie;
      if (buffer.control_late) calibration.written_late();
      if (buffer.damaged)
        TRY(drops.damaged(id));
      else if (const Result<void> unpacked = unpack_pixels(buffer, how.unpack, codes); !unpacked)
        TRY(drops.not_decoded(id, unpacked.error()));
      else
        drops.end(), readable = true;
    }  // the buffer goes back before the next request needs it
    TRY(requests.queue_next());
    if (!readable) {
      calibration.note_request(index, requests.after(completed));
      continue;
    }
    calibration.photometer().observe(codes, kind.layout, kind.bits, picture);
    calibration.observe(index, picture, requests.after(completed));
  }
  return {};
}

}  // namespace

Result<DelayEstimate> measure_delay(Camera& camera, const DelayMeasurement& how,
                                    const std::atomic<bool>& stop) {
  const bool linear = codes_of(how.mode.format).linear;
  DelayCalibration calibration(how.shorter, how.longer,
                               PhotometricResponse::before_any_fit(linear, std::nullopt));
  TRY(camera.start());
  const Result<void> observed = observe_pictures(camera, how, stop, calibration);
  const Result<void> stopped = camera.stop();
  if (!observed) return observed.error();  // the first of the two is the reason
  TRY(stopped);
  return calibration.estimate();
}

}  // namespace hdrcam
