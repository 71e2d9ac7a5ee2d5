// Which controls were written when each frame began. A camera writes those of a request when the frame that
// completes it begins (hal/camera.h); while frames are lost the request stays due. Frames that are lost
// because no request is queued keep the controls before it. What is too old, or was completed by two frames,
// is unknown rather than guessed. Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/camera.h"
#include "hal/core/instant.h"

namespace hdrcam {

class ControlHistory {
 public:
  static constexpr int kFrames = 32;    // the newest ones; of earlier frames nothing is known
  static constexpr int kRequests = 64;  // the last ones, those that are queued among them

  struct Request {
    ExposureRequest controls;  // as they were queued
    int slot = -1;             // of the schedule, though a part of it may be held back
    bool late = false;         // the controls were written late or never
    std::optional<Instant> queued{};
  };

  // A request was made, with the next cookie.
  void sent(const ExposureRequest& controls, int slot);
  // When the camera took it; without this it counts as queued before all frames that were lost before its
  // own.
  void queued(std::uint64_t cookie, Instant at);
  // None where that is unknown.
  std::optional<Instant> queued_at(std::uint64_t cookie) const;
  // How many frames, the one that completes a request included, began since the request was queued: at least,
  // and at most.
  struct BegunSince {
    std::uint64_t surely = kFrames, perhaps = kFrames;
  };
  // The next frame completed the request with this cookie; `late`: whose controls were written late or never.
  // False where that request was completed before.
  bool completed(std::uint64_t frame, std::uint64_t cookie, bool late, const BegunSince& begun);
  bool completed(std::uint64_t frame, std::uint64_t cookie, bool late) {
    return completed(frame, cookie, late, {});
  }

  std::uint64_t newest_frame() const { return newest_frame_; }
  // The request whose controls were written when that frame began, or will be if no frame is lost until then;
  // null where it is unknown.
  const Request* written_at(std::int64_t frame) const;

 private:
  std::array<std::optional<Request>, kRequests> requests_{};     // by cookie
  std::array<std::optional<std::uint64_t>, kFrames> cookies_{};  // by frame
  std::uint64_t newest_frame_ = 0;
  std::optional<std::uint64_t> highest_cookie_;  // completed
};

}  // namespace hdrcam
