// One verb of `hdrcam` per file in this folder. A verb adds its flags to the command line; when the user
// names it, `chosen` becomes the function to run. program.cpp parses, runs and turns the Error into one
// sentence and an exit code. Thread-bound.
#pragma once

#include <atomic>
#include <functional>

#include "firmware_host/command_line.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The environment that the program gives to a verb.
struct Surroundings {
  Storage& storage;
  // Set by the first ^C: finish the frame, close the files, return Interrupted.
  const std::atomic<bool>& stop;
};

using Verb = std::function<Result<void>(Surroundings&)>;

void add_import(CommandLine program, Verb& chosen);
void add_export(CommandLine program, Verb& chosen);
void add_info(CommandLine program, Verb& chosen);
void add_repair(CommandLine program, Verb& chosen);
void add_replay(CommandLine program, Verb& chosen);
void add_render(CommandLine program, Verb& chosen);
void add_encode(CommandLine program, Verb& chosen);
void add_compare(CommandLine program, Verb& chosen);
void add_live(CommandLine program, Verb& chosen);
void add_record(CommandLine program, Verb& chosen);
void add_calibrate(CommandLine program, Verb& chosen);
void add_list(CommandLine program, Verb& chosen);
void add_simulate(CommandLine program, Verb& chosen);
void add_bench(CommandLine program, Verb& chosen);
void add_completion(CommandLine program, Verb& chosen);
void add_manual(CommandLine program, Verb& chosen);

}  // namespace hdrcam
