// One verb of `hdrcam` per file in this folder. A verb adds its flags to the command line; when the user
// names it, `chosen` becomes the function to run. program.cpp parses, runs and turns the Error into one
// sentence and an exit code.
#pragma once

#include <atomic>
#include <functional>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace CLI {
class App;
}

namespace hdrcam {

// The environment that the program gives to a verb.
struct Surroundings {
  Storage& storage;
  const std::atomic<bool>&
      stop;  // set by the first ^C: finish the frame, close the files, return Interrupted
};

using Verb = std::function<Result<void>(Surroundings&)>;

void add_import(CLI::App& app, Verb& chosen);
void add_export(CLI::App& app, Verb& chosen);
void add_info(CLI::App& app, Verb& chosen);
void add_repair(CLI::App& app, Verb& chosen);
void add_replay(CLI::App& app, Verb& chosen);
void add_render(CLI::App& app, Verb& chosen);
void add_encode(CLI::App& app, Verb& chosen);
void add_compare(CLI::App& app, Verb& chosen);
void add_live(CLI::App& app, Verb& chosen);
void add_record(CLI::App& app, Verb& chosen);
void add_calibrate(CLI::App& app, Verb& chosen);
void add_list(CLI::App& app, Verb& chosen);
void add_simulate(CLI::App& app, Verb& chosen);
void add_bench(CLI::App& app, Verb& chosen);
void add_completion(CLI::App& app, Verb& chosen);
void add_manual(CLI::App& app, Verb& chosen);

}  // namespace hdrcam
