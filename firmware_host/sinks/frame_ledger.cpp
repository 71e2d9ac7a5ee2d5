#include "firmware_host/sinks/frame_ledger.h"

#include <fmt/format.h>

#include <span>

namespace hdrcam {

Result<FrameLedger> FrameLedger::create(Storage& storage, const std::string& folder) {
  FrameLedger ledger(TRY(storage.create(folder + "/" + kFile, Creation::Replace)));
  TRY(ledger.write("number,time_s,exposure_s,analogue_gain,digital_gain,exposure_source,verdict,file\n"));
  return ledger;
}

Result<void> FrameLedger::append(const FrameFacts& facts, const std::string& file) {
  return write(fmt::format("{},{:.9f},{:.9g},{:.6g},{:.6g},{},{},{}\n", facts.sequence,
                           facts.timestamp.seconds(), facts.exposure_s, facts.analogue_gain,
                           facts.digital_gain, name(facts.exposure_source),
                           facts.verdict ? name(*facts.verdict) : "", file));
}

Result<void> FrameLedger::write(const std::string& line) {
  TRY(file_->write_at(bytes_, std::as_bytes(std::span(line))));
  bytes_ += line.size();
  return {};
}

}  // namespace hdrcam
