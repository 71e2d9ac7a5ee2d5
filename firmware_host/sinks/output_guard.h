// Stands between a run and what is already on the disk. Before anything is opened, every output is held
// against every input and every other output: the same file under any name is refused, and so is what an
// earlier run left (a recording, numbered frames), unless the user says --force. Reentrant.
#pragma once

#include <span>
#include <string>

#include "hal/storage.h"

namespace hdrcam {

struct NamedInput {
  std::string what;  // for the sentence: "the recording that is read"
  std::string path;
};

enum class OutputKind {
  Frames,     // a pattern, one file per frame: earlier frames stay unless --force
  Recording,  // an earlier take stays unless --force
  Page,       // statistics, a report, a sheet: made anew by every run
};

struct NamedOutput {
  std::string flag;  // "--report"
  std::string path;  // as the user gave it; "": not wanted
  OutputKind kind = OutputKind::Page;
};

enum class Overwrite { Refuse, Force };

// Errors: Invalid where an output is an input, another output, or a page over a file of another kind (its
// extension tells); Exists where an earlier take would go; those of Storage::look_at.
Result<void> check_outputs(Storage& storage, std::span<const NamedInput> inputs,
                           std::span<const NamedOutput> outputs, Overwrite overwrite);

}  // namespace hdrcam
