#include "capture/exposure.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hal/core/sound_facts.h"
#include "hal/core/split_text.h"

namespace hdrcam {
namespace {

constexpr double kShortest_s = 1e-9, kLongest_s = 3600;
constexpr double kGainRounding = 1e-9;

// Parses the number at the start of the text and removes it from the text; nullopt where there is none.
std::optional<double> take_number(std::string_view& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::optional<double> seconds_in(std::string_view text) {
  auto number = take_number(text);
  if (!number) return std::nullopt;
  if (text.starts_with('/')) {
    text.remove_prefix(1);
    const auto divisor = take_number(text);
    if (!divisor || *divisor == 0) return std::nullopt;
    *number /= *divisor;
  }
  text = trimmed(text);
  if (text.empty() || text == "s") return number;
  if (text == "ms") return *number * 1e-3;
  if (text == "us") return *number * 1e-6;
  return std::nullopt;
}

// The number that is the whole text.
std::optional<double> bare_number(std::string_view text) {
  text = trimmed(text);
  const auto number = take_number(text);
  return text.empty() ? number : std::nullopt;
}

Error lacks_unit(std::string_view text) {
  return {ErrorCode::Invalid, fmt::format("the time '{0}' has no unit; write {0}ms or {0}s", trimmed(text))};
}

// sorted: at least one.
double nearest_of(std::span<const double> sorted, double value) {
  const auto above = std::ranges::lower_bound(sorted, value);
  if (above == sorted.begin()) return sorted.front();
  if (above == sorted.end() || value - *(above - 1) < *above - value) return *(above - 1);
  return *above;
}

// So many steps above the shortest, to the nearest nanosecond.
Duration after_steps(std::int64_t steps, const CameraCapabilities& camera) {
  return camera.exposure_min + std::chrono::round<Duration>(steps * camera.exposure_step);
}

}  // namespace

bool outlasts_frame(double exposure_s, double interval_s) {
  constexpr double kRounding = 1.05;
  return interval_s > 0 && exposure_s > kRounding * interval_s;
}

Duration between_begins(const FrameFacts& frame, const FrameFacts& next) {
  const Duration between_centres = next.timestamp - frame.timestamp;
  for (const FrameFacts* facts : {&frame, &next})
    if (!facts->has_exposure() || !facts->has_exposure_time()) return between_centres;
  return between_centres + from_seconds((frame.exposure_s - next.exposure_s) / 2);
}

double log_product(const Exposure& exposure) { return std::log(exposure.product()); }

bool all_same(std::span<const Exposure> cycle) {
  return std::ranges::all_of(cycle, [&](const Exposure& exposure) {
    return same_exposure(log_product(exposure), log_product(cycle.front()));
  });
}

Result<Duration> parse_duration(std::string_view text) {
  if (bare_number(text).value_or(0) > 0) return lacks_unit(text);
  const auto seconds = seconds_in(trimmed(text));
  if (!seconds || !is_within(*seconds, kShortest_s, kLongest_s))
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' is {}; write it like 4ms, 250us, 1/250 or 0.004s", text,
                             seconds ? fmt::format("outside {:g}us to {:g}s", kShortest_s * 1e6, kLongest_s)
                                     : "not a duration")};
  return from_seconds(*seconds);
}

Result<Duration> parse_signed_duration(std::string_view text) {
  const auto number = bare_number(text);
  if (number && *number != 0) return lacks_unit(text);
  const auto seconds = number ? number : seconds_in(trimmed(text));
  if (!seconds || !(std::abs(*seconds) <= kLongest_s))
    return Error{ErrorCode::Invalid, fmt::format("'{}' is not a time; write it like 250us, -2ms or 0", text)};
  return from_seconds(*seconds);
}

double usual_gain(const CameraCapabilities& camera) { return std::max(1.0, camera.gain_min); }

Result<std::vector<Exposure>> parse_exposures(std::string_view shutter, std::string_view gain,
                                              double gain_otherwise) {
  std::vector<Exposure> exposures;
  for (const std::string_view part : split(shutter, ',')) {
    const auto time = parse_duration(part);
    if (!time)
      return Error{time.error().code, fmt::format("shutter times '{}': {}", shutter, time.error().message)};
    exposures.push_back({time.value(), gain_otherwise});
  }
  if (trimmed(gain).empty()) return exposures;

  const auto gains = split(gain, ',');
  if (exposures.size() == 1) exposures.resize(gains.size(), exposures.front());
  if (gains.size() != 1 && gains.size() != exposures.size())
    return Error{ErrorCode::Invalid,
                 fmt::format("'{}' has {} gains for {} shutter times; give one gain, or one each", gain,
                             gains.size(), exposures.size())};
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    std::string_view part = trimmed(gains[gains.size() == 1 ? 0 : i]);
    const std::string_view whole = part;
    const auto number = take_number(part);
    if (!number || !part.empty() || !(*number > 0) || *number > kMostExposureGain)
      return Error{ErrorCode::Invalid,
                   fmt::format("'{}' is not a gain; write a number above 0, up to {}, like 1 or 2.5", whole,
                               kMostExposureGain)};
    exposures[i].gain = *number;
  }
  return exposures;
}

std::string describe(Duration duration) {
  const double seconds = to_seconds(duration);
  if (seconds >= 1) return fmt::format("{:.4g} s", seconds);
  if (seconds >= 1e-3) return fmt::format("{:.4g} ms", seconds * 1e3);
  return fmt::format("{:.4g} us", seconds * 1e6);
}

std::string describe(const Exposure& exposure) {
  if (exposure.gain == 1) return describe(exposure.time);
  return fmt::format("{} x {:.4g}", describe(exposure.time), exposure.gain);
}

std::string describe(std::span<const Exposure> cycle) {
  std::string text;
  for (const Exposure& exposure : cycle) text += (text.empty() ? "" : ", ") + describe(exposure);
  return text;
}

Result<Exposure> quantised(const Exposure& exposure, const CameraCapabilities& camera) {
  // A value up to half a step outside the range still rounds into it.
  const auto half_step = std::chrono::duration_cast<Duration>(camera.exposure_step / 2);
  if (exposure.time < camera.exposure_min - half_step || exposure.time > camera.exposure_max + half_step)
    return Error{ErrorCode::BadExposure,
                 fmt::format("shutter {} is outside what '{}' offers, {} to {}; choose one within",
                             describe(exposure.time), camera.id, describe(camera.exposure_min),
                             describe(camera.exposure_max))};
  const std::vector<double>& gains = camera.gains;
  const bool uneven = gains.size() > 1;
  const double lowest_step = uneven ? gains[1] - gains[0] : camera.gain_step;
  const double highest_step = uneven ? gains.back() - gains[gains.size() - 2] : camera.gain_step;
  if (exposure.gain < camera.gain_min - (lowest_step / 2 + kGainRounding) ||
      exposure.gain > camera.gain_max + (highest_step / 2 + kGainRounding))
    return Error{ErrorCode::BadExposure,
                 fmt::format("gain {:.4g} is outside what '{}' offers, {:.4g} to {:.4g}; choose one within",
                             exposure.gain, camera.id, camera.gain_min, camera.gain_max)};

  Exposure nearest = exposure;
  if (camera.exposure_step > Duration(1))
    nearest.time =
        after_steps((exposure.time - camera.exposure_min + half_step) / camera.exposure_step, camera);
  nearest.time = std::clamp(nearest.time, camera.exposure_min, camera.exposure_max);
  if (uneven)
    nearest.gain = nearest_of(gains, exposure.gain);
  else if (camera.gain_step > 0)
    nearest.gain =
        camera.gain_min + std::round((exposure.gain - camera.gain_min) / camera.gain_step) * camera.gain_step;
  nearest.gain = std::clamp(nearest.gain, camera.gain_min, camera.gain_max);
  return nearest;
}

Duration longest_within(Duration limit, const CameraCapabilities& camera) {
  if (camera.exposure_step <= Duration(1) || limit < camera.exposure_min) return limit;
  const std::int64_t steps = (limit - camera.exposure_min) / camera.exposure_step;
  const Duration next = after_steps(steps + 1, camera);  // rounded down, it may be within
  return next <= limit ? next : after_steps(steps, camera);
}

}  // namespace hdrcam
