#include "firmware_host/commands/trace_file.h"

#include <span>

#include "firmware_host/terminal.h"

namespace hdrcam {

Result<void> TraceFile::write_after(const Result<void>& run, Storage& storage) const {
  if (!trace_) return run;
  if (const std::uint64_t left_out = trace_->left_out(); left_out > 0)
    remark("note: the trace is full; its last {} spans are left out\n", left_out);
  const std::string json = trace_->json();
  const Result<void> written = write_whole(storage, path_, std::as_bytes(std::span(json)));
  if (run) return written;
  if (!written) remark("warning: {}\n", written.error().message);
  return run;
}

}  // namespace hdrcam
