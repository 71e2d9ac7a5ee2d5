#include "firmware_host/footage/footage_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "capture/exposure_schedule.h"
#include "firmware_host/footage/low_codes.h"
#include "hal/core/counted.h"

namespace hdrcam {

Result<FootageScan> scan_footage(FootageReader& footage, const std::atomic<bool>& stop) {
  constexpr std::size_t kLags = ExposureSchedule::kMaxSlots;
  FootageScan seen;
  seen.camera = footage.camera(), seen.about = footage.about();
  seen.steps.resize(kLags);
  const auto response_of = [&](const FrameFacts& facts) {  // each raw still states its own black level
    return PhotometricResponse::before_any_fit(seen.camera.linear, facts.black_level);
  };
  Photometer photometer(response_of({}));
  std::array<PhotometricSignature, kLags + 1> recent;  // by frame number, round and round
  LowCodes low(seen.camera);
  RawFrame frame;
  while (TRY(footage.next(frame))) {
    if (stop)
      return Error{ErrorCode::Interrupted,
                   fmt::format("stopped at frame {}; nothing was written", seen.facts.size())};
    const std::size_t i = seen.facts.size();
    PhotometricSignature& here = recent[i % recent.size()];
    photometer.set_response(response_of(frame.facts));
    photometer.observe(frame.codes, seen.camera.layout, seen.camera.bits, here);
    for (std::size_t lag = 1; lag <= std::min(kLags, i); ++lag)
      seen.steps[lag - 1].push_back(step_between(photometer, recent[(i - lag) % recent.size()], here));
    if (seen.paths.empty() || seen.paths.back() != footage.path())
      seen.paths.push_back(footage.path()), seen.begins.push_back(i);
    low.observe(frame.codes);
    seen.facts.push_back(frame.facts);
    seen.taken.push_back(footage.taken());
    seen.stills |= footage.still();
    if (seen.timed.empty() && footage.timed()) seen.timed = footage.path();
    seen.iso.note(footage.factors().iso, footage.path());
    seen.f_number.note(footage.factors().f_number, footage.path());
    if (seen.silent.empty() && frame.facts.exposure_source != ExposureSource::Embedded)
      seen.silent = footage.path();
  }
  seen.camera.name = footage.camera().name;  // all files have been seen now
  seen.losses = footage.losses(), seen.low_codes = low.suspicion();
  seen.primaries = footage.primaries();
  seen.orientations = footage.orientations(), seen.oblique = footage.oblique();
  if (seen.facts.size() < 2)
    return Error{ErrorCode::TooShort,
                 fmt::format("'{}' holds {}; a clip has at least two: name more files, or their folder",
                             seen.paths.front(), counted(seen.facts.size(), "frame"))};
  return seen;
}

}  // namespace hdrcam
