// The shape of the house, checked: what a stage may include, and what may stand at the top level.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/places.h"

#include <catch2/catch.hpp>

namespace {

namespace fs = std::filesystem;

// In the direction in which a frame travels. A folder may include itself and those before it.
constexpr std::array<std::string_view, 5> kStages{"hal", "capture", "online", "render", "firmware_host"};

std::optional<std::size_t> stage_of(std::string_view path) {
  const std::string_view folder = path.substr(0, path.find('/'));
  const auto* const found = std::find(kStages.begin(), kStages.end(), folder);
  if (found == kStages.end() || folder == path) return std::nullopt;
  return static_cast<std::size_t>(found - kStages.begin());
}

// The file that a line includes with quotes, or nullopt. Spaces are allowed where the preprocessor allows
// them.
std::optional<std::string> quoted_include(std::string_view line) {
  const auto skip_blanks = [&line] {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  };
  skip_blanks();
  if (!line.starts_with('#')) return std::nullopt;
  line.remove_prefix(1);
  skip_blanks();
  if (!line.starts_with("include")) return std::nullopt;
  line.remove_prefix(std::string_view("include").size());
  skip_blanks();
  const bool angled = line.starts_with('<');
  if (!angled && !line.starts_with('"')) return std::nullopt;
  const std::string file(line.substr(1, line.find_first_of(angled ? ">" : "\"", 1) - 1));
  // <hal/...> would reach our headers, too; <vector> and <opencv2/...> do not.
  return angled && !stage_of(file) ? std::nullopt : std::optional(file);
}

// One sentence per include that runs against the direction, leaves the house, or is not spelled from the
// root. path: of the including file, from the root.
std::vector<std::string> wrong_includes(const std::string& path, std::istream& text) {
  std::vector<std::string> wrong;
  const auto from = stage_of(path);
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    const auto file = quoted_include(line);
    if (!file) continue;
    const auto to = stage_of(*file);
    if (!to)
      wrong.push_back(path + ":" + std::to_string(number) + " includes \"" + *file +
                      "\", which is not a path from the root");
    else if (*to > *from)
      wrong.push_back(path + ":" + std::to_string(number) + " includes \"" + *file +
                      "\", which lies downstream");
  }
  return wrong;
}

std::vector<std::string> wrong_includes(const std::string& path, const std::string& text) {
  std::istringstream stream(text);
  return wrong_includes(path, stream);
}

// Which rooms of a folder include which: by folder, then by room. A room is a folder in it; files that stand
// in the folder itself belong to no room, they join them.
using Rooms = std::map<std::string, std::map<std::string, std::set<std::string>>>;

// Notes which rooms an include joins: the two folders at which the paths part, where both are on one floor.
void note_rooms(const std::string& path, const std::string& included, Rooms& rooms) {
  const auto folders = [](const std::string& file) {
    std::vector<std::string> parts;
    std::istringstream stream(file);
    for (std::string part; std::getline(stream, part, '/');) parts.push_back(part);
    parts.pop_back();
    return parts;
  };
  const std::vector<std::string> from = folders(path), to = folders(included);
  std::size_t shared = 0;
  while (shared < std::min(from.size(), to.size()) && from[shared] == to[shared]) ++shared;
  if (shared == 0 || shared == from.size() || shared == to.size()) return;
  std::string house = from[0];
  for (std::size_t i = 1; i < shared; ++i) house += "/" + from[i];
  rooms[house][from[shared]].insert(to[shared]);
}

// One sentence per folder whose rooms include each other in a circle, naming the way round.
std::vector<std::string> circles(const Rooms& rooms) {
  std::vector<std::string> found;
  for (const auto& [house, doors] : rooms) {
    std::set<std::string> finished;
    std::vector<std::string> way;
    const std::function<bool(const std::string&)> closes = [&, &house = house,
                                                            &doors = doors](const std::string& room) {
      const auto before = std::find(way.begin(), way.end(), room);
      if (before != way.end()) {
        std::string sentence = house + ": ";
        for (auto step = before; step != way.end(); ++step) sentence += *step + " -> ";
        found.push_back(sentence + room + " is a circle");
        return true;
      }
      if (finished.contains(room) || !doors.contains(room)) return false;
      way.push_back(room);
      for (const std::string& next : doors.at(room))
        if (closes(next)) return true;
      way.pop_back();
      finished.insert(room);
      return false;
    };
    for (const auto& [room, to] : doors)
      if (closes(room)) break;
  }
  return found;
}

// The names that do not belong at the top level.
std::vector<std::string> strangers(const std::vector<std::string>& names) {
  static const std::set<std::string> kFixed{
      "CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "docs", "examples", "run",
      "firmware_host",  "capture",           "online",  "render",    "hal",  "tests"};
  static const std::set<std::string> kIgnoredByGit{"build", "out", "compile_commands.json"};
  std::vector<std::string> unknown;
  for (const std::string& name : names)
    if (!name.starts_with('.') && !kFixed.contains(name) && !kIgnoredByGit.contains(name))
      unknown.push_back(name);
  return unknown;
}

const fs::path kRoot = HDRCAM_SOURCE_DIR;

}  // namespace

TEST_CASE("every include runs hal <- capture <- online <- render <- firmware_host") {
  std::vector<std::string> wrong;
  int files = 0;
  for (const std::string_view stage : kStages)
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / stage)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream text(entry.path());
      REQUIRE(text.good());
      const auto found = wrong_includes(fs::relative(entry.path(), kRoot).generic_string(), text);
      wrong.insert(wrong.end(), found.begin(), found.end());
      ++files;
    }
  CHECK(files > 600);
  for (const std::string& sentence : wrong) FAIL_CHECK(sentence);
}

TEST_CASE("no two rooms of a floor include each other, however long the way round") {
  Rooms rooms;
  for (const std::string_view stage : kStages)
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / stage)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream text(entry.path());
      REQUIRE(text.good());
      for (std::string line; std::getline(text, line);)
        if (const auto file = quoted_include(line))
          note_rooms(fs::relative(entry.path(), kRoot).generic_string(), *file, rooms);
    }
  CHECK(rooms["online"]["scene"].contains("state"));
  for (const std::string& sentence : circles(rooms)) FAIL_CHECK(sentence);
}

TEST_CASE("nothing unknown stands at the top level") {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kRoot)) names.push_back(entry.path().filename().string());
  REQUIRE(names.size() > kStages.size());
  for (const std::string& name : strangers(names))
    FAIL_CHECK("'" << name << "' does not belong at the top level");
}

TEST_CASE("the check of includes lets through what runs along") {
  CHECK(wrong_includes("online/scene/hash_grid/fit/adam.cpp",
                       "#include \"online/scene/hash_grid/fit/adam.h\"\n#include \"hal/core/image.h\"\n")
            .empty());
  CHECK(wrong_includes("firmware_host/main.cpp", "#include <vector>\n#include \"render/exr.h\"\n").empty());
  CHECK(wrong_includes("hal/core/cpu.h", "// #include \"render/exr.h\"\n").empty());
}

TEST_CASE("the check of includes finds what runs against it, however it is spelled") {
  const std::vector<std::string> spellings{"#include \"render/exr.h\"", "  #  include\t\"render/exr.h\"",
                                           "#include<render/exr.h>", "#include \"render/exr.h\"  // why not"};
  for (const std::string& line : spellings) {
    INFO(line);
    CHECK(wrong_includes("hal/core/image.h", "#pragma once\n" + line + "\n") ==
          std::vector<std::string>{"hal/core/image.h:2 includes \"render/exr.h\", which lies downstream"});
    CHECK(wrong_includes("render/png.cpp", line).empty());
  }
  for (std::size_t from = 0; from < kStages.size(); ++from)
    for (std::size_t to = 0; to < kStages.size(); ++to) {
      const std::string path = std::string(kStages[from]) + "/a.h";
      const std::string line = "#include \"" + std::string(kStages[to]) + "/b.h\"";
      CHECK(wrong_includes(path, line).empty() == (to <= from));
    }
}

TEST_CASE("the check of includes finds a header that is not named from the root, or is a test's") {
  for (const char* file :
       {"exr.h", "../hal/core/image.h", "tests/firmware_host/sinks/example_run.h", "render"}) {
    INFO(file);
    CHECK(wrong_includes("firmware_host/main.cpp", "#include \"" + std::string(file) + "\"").size() == 1);
  }
}

TEST_CASE("the check of rooms finds a circle, and where it is") {
  Rooms rooms;
  note_rooms("online/state/a.h", "online/pictures/b.h", rooms);
  note_rooms("online/state/a.h", "hal/core/image.h", rooms);                      // another floor
  note_rooms("online/scene/hash_grid/a.h", "online/scene/scene_field.h", rooms);  // the folder around it
  note_rooms("online/scene/fields.cpp", "online/scene/hash_grid/a.h", rooms);     // joins the rooms
  note_rooms("online/online_stage.h", "online/state/a.h", rooms);
  CHECK(circles(rooms).empty());
  note_rooms("online/priors/motion/a.h", "online/state/a.h", rooms);
  note_rooms("online/pictures/b.cpp", "online/priors/seen.h", rooms);
  CHECK(circles(rooms) ==
        std::vector<std::string>{"online: pictures -> priors -> state -> pictures is a circle"});
  note_rooms("hal/sim/effects/a.h", "hal/sim/scenes/b.h", rooms);
  note_rooms("hal/sim/scenes/b.cpp", "hal/sim/effects/c.h", rooms);
  CHECK(circles(rooms).front() == "hal/sim: effects -> scenes -> effects is a circle");
}

TEST_CASE("the check of the top level finds strangers") {
  CHECK(strangers({"hal", "README.md", ".clang-format", ".ci", "build", "run"}).empty());
  CHECK(strangers({"hal", "utils", "notes.txt"}) == std::vector<std::string>{"utils", "notes.txt"});
}
