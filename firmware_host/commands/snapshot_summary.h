// The summary of a saved scene for `hdrcam info`: what its head says, shown as a table or as JSON, after all
// checksums were found right. Reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "firmware_host/film/scene_snapshot.h"

namespace hdrcam {

// bytes: of the file.
std::string as_table(const SceneHead& scene, const std::string& path, std::uint64_t bytes);
std::string as_json(const SceneHead& scene, const std::string& path, std::uint64_t bytes);

}  // namespace hdrcam
