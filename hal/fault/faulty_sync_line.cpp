#include "hal/fault/faulty_sync_line.h"

#include <algorithm>
#include <utility>

namespace hdrcam {

bool FaultySyncLine::has(LineFaultKind kind, std::uint64_t edge) const {
  return std::any_of(faults_.begin(), faults_.end(),
                     [&](const LineFault& fault) { return fault.kind == kind && fault.at == edge; });
}

Result<Edge> FaultySyncLine::wait_edge(Duration timeout) {
  if (repeat_) return *std::exchange(repeat_, std::nullopt);
  for (;;) {
    if (has(LineFaultKind::Unplug, edges_))
      return Error{ErrorCode::Unplugged, "the line went away (injected fault)"};
    if (has(LineFaultKind::Timeout, edges_) && !std::exchange(refused_, true))
      return Error{ErrorCode::Timeout, "no edge came (injected fault)"};
    Edge edge = TRY(inner_->wait_edge(timeout));
    const std::uint64_t number = edges_++;
    refused_ = false;
    if (has(LineFaultKind::Unseen, number)) ++hidden_;
    if (has(LineFaultKind::Unseen, number) || has(LineFaultKind::Lost, number)) continue;
    edge.sequence = edge.sequence + added_ - hidden_;
    if (has(LineFaultKind::Late, number)) edge.at = edge.at + std::chrono::milliseconds(5);
    if (has(LineFaultKind::Spurious, number)) {
      ++added_;
      repeat_ = Edge{edge.at + std::chrono::microseconds(1), edge.rising, edge.sequence + 1};
    }
    return edge;
  }
}

}  // namespace hdrcam
