#include "firmware_host/commands/trace_file.h"

#include <span>
#include <string>

#include "firmware_host/run/output_needs.h"
#include "firmware_host/terminal.h"

namespace hdrcam {

Result<void> TraceFile::write_after(const Result<void>& run, Storage& storage) const {
  if (!trace_) return run;
  if (const std::uint64_t left_out = trace_->left_out(); left_out > 0)
    remark("note: the trace is full; its last {} spans are left out\n", left_out);
  const std::string json = trace_->json();
  const std::string& path = settings_.machine.trace;
  const Result<void> written = write_whole(storage, path, std::as_bytes(std::span(json)));
  if (written) write_result_beside_frames(settings_.output, path + "\n");
  if (run) return written;
  if (!written) remark("warning: {}\n", written.error().message);
  return run;
}

}  // namespace hdrcam
