#include "firmware_host/commands/json_flag.h"

#include <fmt/format.h>

#include <span>

#include "firmware_host/command_line.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/sinks/sink_table.h"
#include "firmware_host/terminal.h"

namespace hdrcam {

void JsonFlag::add_to(CommandLine verb, const char* what) {
  const std::string help =
      fmt::format("also write {} to this file; -: print them instead of the table", what);
  verb.add_option("--json", path_, help.c_str()).transform(named_at_start).check(names_file);
}

NamedOutput JsonFlag::output() const { return {"--json", stands_for_table() ? "" : path_}; }

bool JsonFlag::stands_for_table() const { return path_ == kStandardOutput; }

Result<void> JsonFlag::write(Storage& storage, const std::string& json) const {
  if (path_.empty()) return {};
  if (stands_for_table()) return write_result(json), Result<void>{};
  return write_whole(storage, path_, std::as_bytes(std::span(json)));
}

}  // namespace hdrcam
