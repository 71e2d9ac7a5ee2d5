// A sync line that fails on request; it wraps a working one. Faults are counted in edges of the wrapped line,
// from 0. For tests. Thread safety of the wrapped line; it allocates nothing per edge.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/sync_line.h"

namespace hdrcam {

enum class LineFaultKind {
  Lost,      // the kernel's queue was full; the sequence number shows the gap
  Unseen,    // the pulse was too short for the interrupt; no gap shows it
  Spurious,  // a glitch: the edge comes twice, a microsecond apart, with consecutive numbers
  Late,      // stamped 5 ms late
  Timeout,   // this edge's wait times out at once; the next wait gets it
  Unplug,    // from this edge on: Unplugged
};

struct LineFault {
  std::uint64_t at = 0;  // the edge
  LineFaultKind kind = LineFaultKind::Lost;
};

class FaultySyncLine : public SyncLine {
 public:
  FaultySyncLine(std::unique_ptr<SyncLine> inner, std::vector<LineFault> faults)
      : inner_(std::move(inner)), faults_(std::move(faults)) {}

  Result<Edge> wait_edge(Duration timeout) override;
  void close() override { inner_->close(); }

 private:
  bool has(LineFaultKind kind, std::uint64_t edge) const;

  std::unique_ptr<SyncLine> inner_;
  std::vector<LineFault> faults_;
  std::uint64_t edges_ = 0;               // taken from the wrapped line
  std::uint64_t added_ = 0, hidden_ = 0;  // shifts of the sequence numbers
  std::optional<Edge> repeat_;
  bool refused_ = false;  // the wait for the next edge, once
};

}  // namespace hdrcam
