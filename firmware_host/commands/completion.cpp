// hdrcam completion SHELL: prints the completion of this command line for a shell.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "firmware_host/commands/command.h"
#include "firmware_host/packaging/shell_completion.h"
#include "firmware_host/terminal.h"

namespace hdrcam {
namespace {

Result<void> print_completion(const CLI::App& app, const std::string& shell) {
  const CommandTable table = command_table(app);
  if (shell == "bash") return write_result(bash_completion(table)), Result<void>{};
  if (shell == "zsh") return write_result(zsh_completion(table)), Result<void>{};
  if (shell == "fish") return write_result(fish_completion(table)), Result<void>{};
  return Error{ErrorCode::Invalid,
               fmt::format("there is no completion for '{}'; give bash, zsh or fish", shell)};
}

}  // namespace

void add_completion(CLI::App& app, Verb& chosen) {
  auto shell = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand("completion", "print the completion of this command line for a shell");
  verb->add_option("shell", *shell, "for bash: source <(hdrcam completion bash)")
      ->type_name("bash|zsh|fish")
      ->required();
  verb->callback([shell, &app, &chosen] {
    chosen = [shell, &app](Surroundings&) { return print_completion(app, *shell); };
  });
}

}  // namespace hdrcam
