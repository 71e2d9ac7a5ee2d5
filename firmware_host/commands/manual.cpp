// hdrcam manual -o FOLDER: writes the manual pages of the program and of its verbs.
#include <memory>
#include <span>
#include <string>

#include "firmware_host/command_line.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/packaging/manual_pages.h"
#include "firmware_host/settings/start_time.h"
#include "hal/storage.h"

namespace hdrcam {

void add_manual(CommandLine program, Verb& chosen) {
  auto folder = std::make_shared<std::string>();
  CommandLine verb = program.add_verb("manual", "write the manual pages, for an installation");
  verb.add_option("-o,--output", *folder, "the folder: hdrcam.1, and hdrcam-VERB.1 for each verb")
      .required()
      .transform(named_at_start)
      .check(names_folder);
  verb.on_chosen([folder, program, &chosen] {
    chosen = [folder, program](Surroundings& around) -> Result<void> {
      TRY(around.storage.make_directories(*folder));
      for (const ManualPage& page : manual_pages(command_table(program)))
        TRY(write_whole(around.storage, *folder + "/" + page.name, std::as_bytes(std::span(page.roff))));
      return {};
    };
  });
}

}  // namespace hdrcam
