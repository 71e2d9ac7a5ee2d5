// The program around the verbs: command line in, exit code out. main.cpp adds the process (signals, the real
// disk); tests call run_program() in-process with a disk of their own. Reentrant.
#pragma once

#include <atomic>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>

#include "firmware_host/commands/command.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// A parsed command line: a verb to run, or (where `verb` is empty) a text to print.
struct Request {
  std::shared_ptr<CLI::App> app;  // owns the flags that `verb` reads
  Verb verb;
  std::string text;
};

// args: without the program's name. Errors: Invalid, one sentence that names the unknown word and, where one
// is near, the word that was probably meant.
Result<Request> parse_command_line(std::span<const char* const> args);

// Parses and runs. Requested texts go to `out`; an Error goes to `err` as the one line "hdrcam: <sentence>.".
// stop: becomes true when the user asks to stop. Returns one of exit_codes().
int run_program(std::span<const char* const> args, Storage& storage, const std::atomic<bool>& stop,
                std::ostream& out, std::ostream& err);

}  // namespace hdrcam
