// hdrcam completion SHELL: prints the completion of this command line for a shell.
#include <memory>
#include <string>

#include "firmware_host/commands/command.h"
#include "firmware_host/packaging/shell_completion.h"
#include "firmware_host/terminal.h"

namespace hdrcam {
namespace {

Result<void> print_completion(CommandLine program, const std::string& shell) {
  const CommandTable table = command_table(program);
  if (shell == "bash") return write_result(bash_completion(table)), Result<void>{};
  if (shell == "zsh") return write_result(zsh_completion(table)), Result<void>{};
  if (shell == "fish") return write_result(fish_completion(table)), Result<void>{};
  return Error{ErrorCode::Invalid,
               fmt::format("there is no completion for '{}'; give bash, zsh or fish", shell)};
}

}  // namespace

void add_completion(CommandLine program, Verb& chosen) {
  auto shell = std::make_shared<std::string>();
  CommandLine verb = program.add_verb("completion", "print the completion of this command line for a shell");
  verb.add_option("shell", *shell, "for bash: source <(hdrcam completion bash)")
      .type_name("bash|zsh|fish")
      .required();
  verb.on_chosen([shell, program, &chosen] {
    chosen = [shell, program](Surroundings&) { return print_completion(program, *shell); };
  });
}

}  // namespace hdrcam
