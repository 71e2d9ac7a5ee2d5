// The flag --json FILE of verbs that print a table: the same as JSON beside it, or with "-" in its place.
// Thread-bound.
#pragma once

#include <string>

#include "firmware_host/command_line.h"
#include "firmware_host/sinks/output_guard.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

class JsonFlag {
 public:
  // what: that the table shows, "the scores". This outlives the parser.
  void add_to(CommandLine verb, const char* what);

  NamedOutput output() const;     // for KeptWork::check; no file where there is none
  bool stands_for_table() const;  // "-"
  // The JSON, where the user wants it. Errors: those of the disk.
  Result<void> write(Storage& storage, const std::string& json) const;

 private:
  std::string path_;
};

}  // namespace hdrcam
