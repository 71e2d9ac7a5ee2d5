#include "firmware_host/sinks/frame_ledger.h"

#include <fmt/format.h>

#include <span>
#include <string_view>
#include <utility>

namespace hdrcam {
namespace {

constexpr std::string_view kName = "frames.csv";

// As RFC 4180 has it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::string FrameLedger::path_beside(const FramePattern& frames) {
  return fmt::format("{}/{}{}", frames.folder(), frames.name_before(), kName);
}

bool FrameLedger::is_one(const std::string& path) { return path.ends_with(kName); }

Result<FrameLedger> FrameLedger::create(Storage& storage, const FramePattern& frames) {
  FileInMaking making = TRY(FileInMaking::beside(storage, path_beside(frames)));
  auto file = TRY(making.create());
  FrameLedger ledger(std::move(making), std::move(file));
  TRY(ledger.write(
      "number,time_s,timestamp_s,exposure_s,analogue_gain,digital_gain,exposure_source,verdict,file\n"));
  return ledger;
}

Result<void> FrameLedger::take_name() {
  if (!named_) TRY(making_.commit(Durability::WrittenBack, Forestalled::Goes));
  named_ = true;
  return {};
}

Result<void> FrameLedger::append(const FrameFacts& facts, double time_s, const std::string& file) {
  TRY(take_name());
  return write(fmt::format("{},{:.9f},{:.9f},{:.9g},{:.6g},{:.6g},{},{},{}\n", facts.sequence, time_s,
                           facts.timestamp.seconds(), facts.exposure_s, facts.analogue_gain,
                           facts.digital_gain, name(facts.exposure_source),
                           facts.verdict ? name(*facts.verdict) : "", cell(file)));
}

Result<void> FrameLedger::write(const std::string& line) {
  TRY(file_->write_at(bytes_, std::as_bytes(std::span(line))));
  bytes_ += line.size();
  return {};
}

}  // namespace hdrcam
