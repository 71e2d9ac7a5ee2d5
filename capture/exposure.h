// An exposure that a sensor can be set to: a time and an analogue gain, and the notation in which a user
// writes them. The picture depends on the product E = time x gain. Value type, reentrant.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/camera.h"
#include "hal/core/frame.h"
#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

struct Exposure {
  Duration time{0};
  double gain = 1;  // analogue

  double product() const { return to_seconds(time) * gain; }  // seconds x gain
  friend bool operator==(const Exposure&, const Exposure&) = default;
};

// ln E, the scale on which exposures are compared; a stop is ln 2.
double log_product(const Exposure& exposure);

// Up to which difference of ln E two exposures count as the same. All limits stand here; they differ because
// their uses differ.
// Claims, labels and slots, each set or stated: rounding to lines and gain codes changes less.
inline constexpr double kSameExposure = 0.05;
inline bool same_exposure(double log_a, double log_b) { return std::abs(log_a - log_b) <= kSameExposure; }
// Whether the exposures of a cycle all count as one, so that no picture can tell them apart.
bool all_same(std::span<const Exposure> cycle);
// A claim outside the cycle and an exposure of it, as far as pictures can tell: the interval of a measured
// ratio reaches 0.1 to each side in a static scene, and more in others (photometry.h).
inline constexpr double kSameToPictures = 0.15;
// Frames of footage a whole cycle apart, by most of their pictures' ratios: what a moving scene does to
// frames of one exposure.
inline constexpr double kSameInFootage = 0.15;
// The first frames of a stream whose cycle is not found: most schedules jitter by less.
inline constexpr double kSameInCycle = 0.2;
// Exposures in use, listed for people: only rounding is left out, so that what an adaptation changed shows.
inline constexpr double kSameInList = 0.01;

// Whether an exposure is longer than its frame by more than rounding explains; its time is then wrong.
bool outlasts_frame(double exposure_s, double interval_s);

// From the beginning of a frame's exposure to that of the next one's, which is a frame duration however the
// two exposures differ. From centre to centre where an exposure time is unknown.
Duration between_begins(const FrameFacts& frame, const FrameFacts& next);

// "4ms", "250us", "1/250", "1/250s", "0.004s". A bare number is refused: few who write one mean seconds.
// Invalid for anything else, and for less than a nanosecond or more than an hour.
Result<Duration> parse_duration(std::string_view text);

// A time before or after another one: "250us", "-2ms", "0". Invalid for anything else, and for a number other
// than 0 without a unit.
Result<Duration> parse_signed_duration(std::string_view text);

// A cycle as the user writes it: shutter "1ms,4ms,16ms", gain "1,1,2". One gain is for all times, one time
// for all gains; empty gains mean gain_otherwise. Invalid, naming the wrong part; so is a gain that no
// recording could hold.
Result<std::vector<Exposure>> parse_exposures(std::string_view shutter, std::string_view gain,
                                              double gain_otherwise = 1);

// Where the user states none: 1, or as little as the sensor can do.
double usual_gain(const CameraCapabilities& camera);

// Returns text like "4 ms x 2"; the gain is left out where it is 1.
std::string describe(Duration duration);
std::string describe(const Exposure& exposure);
// Of a cycle: "1 ms, 4 ms, 16 ms".
std::string describe(std::span<const Exposure> cycle);

// The nearest exposure that the sensor can do: time in whole steps (exposure_step) above the shortest,
// gain in whole codes (gain_step, or gains). BadExposure where it is outside the sensor's range, naming the
// range.
Result<Exposure> quantised(const Exposure& exposure, const CameraCapabilities& camera);

// The longest of the sensor's times that is no longer than the limit; the limit where all are.
Duration longest_within(Duration limit, const CameraCapabilities& camera);

}  // namespace hdrcam
