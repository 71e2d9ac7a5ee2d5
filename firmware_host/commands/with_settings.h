// A verb that runs with settings. With --print-config it prints them instead. Reentrant.
#pragma once

#include <memory>

#include "firmware_host/commands/command.h"
#include "firmware_host/settings/settings_flags.h"

namespace hdrcam {

// flags->settings: those of the verb.
template <class Flags>
Verb with_settings(std::shared_ptr<Flags> flags,
                   Result<void> (*run)(const Flags&, const Settings&, Surroundings&)) {
  return [flags, run](Surroundings& around) -> Result<void> {
    const std::optional<Settings> settings = TRY(flags->settings->read_or_print(around.storage));
    return settings ? run(*flags, *settings, around) : Result<void>{};
  };
}

}  // namespace hdrcam
