// Manual pages in roff (man(7)): hdrcam(1) and one for each verb, hdrcam-VERB(1). Reentrant.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/packaging/command_table.h"

namespace hdrcam {

struct ManualPage {
  std::string name;  // of the file: "hdrcam-replay.1"
  std::string roff;
};

// The program's own first, then the verbs in their order.
std::vector<ManualPage> manual_pages(const CommandTable& table);

}  // namespace hdrcam
