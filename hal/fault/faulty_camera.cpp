#include "hal/fault/faulty_camera.h"

namespace hdrcam {
namespace {

Error unplugged() { return {ErrorCode::Unplugged, "the camera was unplugged (injected fault)"}; }

}  // namespace

Result<void> FaultyCamera::start() { return unplugged_ ? Result<void>(unplugged()) : inner_->start(); }

Result<void> FaultyCamera::queue(const ExposureRequest& request) {
  return unplugged_ ? Result<void>(unplugged()) : inner_->queue(request);
}

Result<CapturedBuffer> FaultyCamera::wait(Duration timeout) {
  for (const CameraFault& fault : faults_) {
    if (fault.at != delivered_) continue;
    if (fault.kind == CameraFaultKind::Unplug) unplugged_ = true;
    if (fault.kind == CameraFaultKind::Timeout && waits_refused_at_ != delivered_) {
      waits_refused_at_ = delivered_;
      return Error{ErrorCode::Timeout, "no frame came (injected fault)"};
    }
  }
  if (unplugged_) return unplugged();
  CapturedBuffer buffer = TRY(inner_->wait(timeout));
  for (const CameraFault& fault : faults_)
    if (fault.at == delivered_) spoil(fault.kind, buffer);
  buffer.sequence += sequence_offset_;
  last_sequence_ = buffer.sequence, last_cookie_ = buffer.cookie;
  ++delivered_;
  return buffer;
}

void FaultyCamera::spoil(CameraFaultKind kind, CapturedBuffer& buffer) {
  switch (kind) {
    case CameraFaultKind::Damaged:
      buffer.damaged = true;
      [[fallthrough]];
    case CameraFaultKind::Short:
      buffer.pixels = buffer.pixels.first(buffer.pixels.size() / 2);
      break;
    case CameraFaultKind::SequenceJump:
      ++sequence_offset_;
      break;
    case CameraFaultKind::SequenceRepeat:
      buffer.sequence = last_sequence_ - sequence_offset_;
      break;
    case CameraFaultKind::StampBack:
      buffer.timestamp = buffer.timestamp + std::chrono::seconds(-1);
      break;
    case CameraFaultKind::CookieRepeat:
      buffer.cookie = last_cookie_;
      break;
    case CameraFaultKind::Timeout:
    case CameraFaultKind::Unplug:
      break;
  }
}

}  // namespace hdrcam
