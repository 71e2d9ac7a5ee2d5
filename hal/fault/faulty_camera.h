// A camera that fails on request: it wraps a working one, so that the program's reaction to a fault can be
// compared with the truth. Faults are counted in buffers, from 0. For tests. Thread safety of the wrapped
// camera; it allocates nothing per frame.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/camera.h"

namespace hdrcam {

enum class CameraFaultKind {
  Timeout,         // this buffer's wait() times out at once; the next wait() gets it
  Unplug,          // from this buffer on everything returns Unplugged
  Damaged,         // half of the pixels are missing, and the driver reports it
  Short,           // half of the pixels are missing, and the driver does not report it
  SequenceJump,    // sequence numbers are larger by one from here on, though no frame is missing
  SequenceRepeat,  // the number of the previous buffer
  StampBack,       // the stamp lies a second in the past
  CookieRepeat,    // the cookie of the previous buffer
};

struct CameraFault {
  std::uint64_t at = 0;  // the buffer
  CameraFaultKind kind = CameraFaultKind::Timeout;
};

class FaultyCamera : public Camera {
 public:
  FaultyCamera(std::unique_ptr<Camera> inner, std::vector<CameraFault> faults)
      : inner_(std::move(inner)), faults_(std::move(faults)) {}

  const CameraCapabilities& capabilities() const override { return inner_->capabilities(); }
  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override {
    return inner_->configure(wanted, buffers);
  }
  Result<void> start() override;
  Result<void> queue(const ExposureRequest& request) override;
  Result<CapturedBuffer> wait(Duration timeout) override;
  Result<void> stop() override { return inner_->stop(); }
  std::vector<std::string> warnings() const override { return inner_->warnings(); }

  std::uint64_t delivered() const { return delivered_; }

 private:
  void spoil(CameraFaultKind kind, CapturedBuffer& buffer);

  std::unique_ptr<Camera> inner_;
  std::vector<CameraFault> faults_;
  std::uint64_t delivered_ = 0, waits_refused_at_ = UINT64_MAX;
  std::uint64_t last_sequence_ = 0, last_cookie_ = 0, sequence_offset_ = 0;
  bool unplugged_ = false;
};

}  // namespace hdrcam
