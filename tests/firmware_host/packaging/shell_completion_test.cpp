#include "firmware_host/packaging/shell_completion.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "online/knobs.h"
#include "tests/support/not_tested.h"
#include "tests/support/ran_here.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shell.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Words = std::set<std::string>;

namespace {

std::string answer_of(const std::vector<std::string>& words) { return test::ran_here(words).out; }

// The flags that --help shows: the first words of its lines.
Words flags_in_help(const std::string& help) {
  Words flags;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  -")) continue;
    std::istringstream names(line.substr(2, line.find_first_of(" =", 2) - 2));
    for (std::string name; std::getline(names, name, ',');) flags.insert(name);
  }
  return flags;
}

CommandTable product() {
  const std::vector<const char*> args{"list"};
  return command_table(*parse_command_line(args).value().app);
}

// Asks bash what it would offer at the end of each of these command lines.
std::map<std::string, Words> offered_by_bash(const std::vector<std::string>& command_lines) {
  const auto script = std::filesystem::temp_directory_path() / ("completion." + std::to_string(getpid()));
  {
    std::ofstream file(script);
    file << bash_completion(product()) << "compopt() { :; }\n"
         << "offer() { COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _hdrcam; echo \"${COMPREPLY[@]}\"; }\n";
    for (const std::string& line : command_lines) file << "offer " << line << "\n";
  }
  std::map<std::string, Words> offered;
  std::FILE* bash = popen(("bash --norc --noprofile " + script.string() + " 2>&1").c_str(), "r");
  REQUIRE(bash != nullptr);
  std::string text;
  for (int c = std::fgetc(bash); c != EOF; c = std::fgetc(bash)) text += static_cast<char>(c);
  CHECK(pclose(bash) == 0);
  std::filesystem::remove(script);
  std::istringstream lines(text);
  for (const std::string& asked : command_lines) {
    std::string line;
    REQUIRE(std::getline(lines, line));
    std::istringstream words(line);
    for (std::string word; words >> word;) offered[asked].insert(word);
  }
  return offered;
}

}  // namespace

TEST_CASE("bash offers every verb, and every flag that the verb's --help shows") {
  std::vector<std::string> lines{"hdrcam ''"};
  Words verbs{"help"};
  for (const VerbEntry& verb : product().verbs) {
    verbs.insert(verb.name);
    lines.push_back("hdrcam " + verb.name + " -");
  }
  const auto offered = offered_by_bash(lines);
  Words first = offered.at("hdrcam ''");
  CHECK(std::ranges::includes(first, verbs));
  CHECK(first.contains("--version"));
  for (const VerbEntry& verb : product().verbs) {
    INFO(verb.name);
    Words flags = flags_in_help(answer_of({verb.name, "--help"}));
    if (verb.name == "bench")
      for (const char* what : {"pareto", "kernels"})
        flags.merge(flags_in_help(answer_of({"bench", what, "--help"})));
    CHECK(flags.contains("--help"));
    CHECK(offered.at("hdrcam " + verb.name + " -") == flags);
  }
}

TEST_CASE("bash offers the flags of 'bench kernels' and 'bench pareto' behind each of them alone") {
  const auto offered = offered_by_bash(
      {"hdrcam bench kernels -", "hdrcam bench pareto -", "hdrcam bench pareto ''", "hdrcam bench kern"});
  for (const std::string inner : {"kernels", "pareto"})
    CHECK(offered.at("hdrcam bench " + inner + " -") == flags_in_help(answer_of({"bench", inner, "--help"})));
  CHECK_FALSE(offered.at("hdrcam bench kernels -").contains("--point"));
  CHECK_FALSE(offered.contains("hdrcam bench pareto ''"));  // bash then offers folders
  CHECK(offered.at("hdrcam bench kern") == Words{"kernels"});
}

TEST_CASE("zsh and fish offer a flag of 'bench pareto' not behind 'bench kernels'") {
  const std::string zsh = zsh_completion(product()), fish = fish_completion(product());
  const std::size_t kernels = zsh.find("[[ $words[2] == kernels ]]"),
                    end = zsh.find("\n        return\n", kernels);
  REQUIRE(end != std::string::npos);
  const std::string behind_kernels = zsh.substr(kernels, end - kernels);
  CHECK_THAT(behind_kernels, Catch::Contains("--seconds=[") && !Catch::Contains("--point"));
  std::istringstream lines(fish);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" -l point ") == std::string::npos) continue;
    CHECK_THAT(
        line, Catch::Contains("from bench; ") && Catch::Contains("not __fish_seen_subcommand_from kernels'"));
  }
}

TEST_CASE("bash offers the words of a flag, however the value is attached, and nothing that does not fit") {
  const auto offered =
      offered_by_bash({"hdrcam replay --preset ''", "hdrcam replay --preset = b",
                       "hdrcam replay walk.mkv --em", "hdrcam replay -o ''", "hdrcam completion ''",
                       "hdrcam calibrate ''", "hdrcam bench ''", "hdrcam help exi", "hdrcam help replay exi",
                       "hdrcam replay --set st", "hdrcam live --backend vul", "hdrcam simulate --format ''"});
  CHECK(offered.at("hdrcam replay --preset ''") == Words{"balanced", "best", "fast", "realtime"});
  CHECK(offered.at("hdrcam replay --preset = b") == Words{"balanced", "best"});
  CHECK(offered.at("hdrcam replay walk.mkv --em") == Words{"--emit"});
  CHECK(offered.contains("hdrcam replay -o ''") == false);  // bash then offers files
  CHECK(offered.at("hdrcam completion ''") == Words{"bash", "fish", "zsh"});
  CHECK(offered.at("hdrcam calibrate ''") == Words{"delay"});
  CHECK(offered.at("hdrcam bench ''") == Words{"kernels", "pareto"});
  CHECK(offered.at("hdrcam help exi") == Words{"exit-codes"});
  CHECK_FALSE(offered.contains("hdrcam help replay exi"));
  CHECK(offered.at("hdrcam simulate --format ''") == Words{"bayer", "rgb"});
  CHECK(offered.at("hdrcam replay --set st").contains("steps="));
  CHECK(offered.at("hdrcam live --backend vul") == Words{"vulkan", "vulkan:"});
}

TEST_CASE("no shell offers the word of an argument again once it is written") {
  const auto offered = offered_by_bash({"hdrcam calibrate --camera x ''", "hdrcam calibrate delay ''",
                                        "hdrcam calibrate delay -", "hdrcam completion bash ''"});
  CHECK(offered.at("hdrcam calibrate --camera x ''") == Words{"delay"});
  CHECK_FALSE(offered.contains("hdrcam calibrate delay ''"));
  CHECK(offered.at("hdrcam calibrate delay -").contains("--camera"));
  CHECK_FALSE(offered.contains("hdrcam completion bash ''"));
  const std::string zsh = zsh_completion(product()), fish = fish_completion(product());
  CHECK_THAT(zsh, Catch::Contains("'1:what:(delay)'") && Catch::Contains("'1:shell:(bash zsh fish)'"));
  CHECK_THAT(zsh, Catch::Contains("'*:footage:_files'"));  // import takes several
  CHECK_THAT(fish, Catch::Contains("and not __fish_seen_subcommand_from delay' -f -a 'delay'"));
  CHECK_THAT(fish, Catch::Contains("and not __fish_seen_subcommand_from bash zsh fish' -f -a"));
}

TEST_CASE("fish offers verbs, flags, words and files, each where it fits") {
  if (test::shell("command -v fish").exit_code != 0) {
    NOT_TESTED("fish is not installed");
    return;
  }
  const std::string folder = test::scratch_folder("completion_fish"), script = folder + "/script.fish";
  std::ofstream(folder + "/walk.mkv") << "";
  const std::vector<std::pair<std::string, std::string>> asked{
      {"hdrcam re", "record render repair replay"},
      {"hdrcam help re", "record render repair replay"},
      {"hdrcam help replay re", ""},
      {"hdrcam replay --pre", "--preset --preview"},
      {"hdrcam replay --preset ", "balanced best fast realtime"},
      {"hdrcam replay --preset=f", "--preset=fast"},
      {"hdrcam replay w", "walk.mkv"},
      {"hdrcam replay -o w", "walk.mkv"},
      {"hdrcam simulate --format ", "bayer rgb"},
      {"hdrcam bench kernels --p", ""},
      {"hdrcam calibrate ", "delay"},
      {"hdrcam calibrate delay ", ""},
      {"hdrcam completion bash ", ""},
      {"hdrcam list w", ""},
      {"hdrcam list --config w", "walk.mkv"}};
  {
    std::ofstream file(script);
    file << fish_completion(product()) << "cd '" << folder << "'\n";
    for (const auto& [line, words] : asked)
      file << "echo (complete -C '" << line << "' | string split -f1 \\t | sort)\n";
  }
  const test::Ran ran = test::shell("fish --no-config '" + script + "'");
  INFO(ran.output);
  REQUIRE(ran.exit_code == 0);
  std::istringstream answers(ran.output);
  for (const auto& [line, words] : asked) {
    std::string answer;
    std::getline(answers, answer);
    CAPTURE(line);
    CHECK(answer == words);
  }
}

TEST_CASE("zsh and fish know every verb, every flag and every word of a flag") {
  const std::string zsh = zsh_completion(product()), fish = fish_completion(product());
  const auto lacks = [](const std::string& text, const std::string& part) {
    return text.find(part) == std::string::npos;
  };
  std::string missing;
  for (const VerbEntry& verb : product().verbs) {
    const std::size_t zsh_begin = zsh.find("\n    " + verb.name + ")\n");
    REQUIRE(zsh_begin != std::string::npos);
    const std::string in_zsh = zsh.substr(zsh_begin, zsh.find(";;", zsh_begin) - zsh_begin);
    std::string in_fish;
    std::istringstream lines(fish);
    for (std::string line; std::getline(lines, line);)
      if (line.find("subcommand_from " + verb.name + ";") != std::string::npos) in_fish += line + '\n';
    if (lacks(fish, " -a " + verb.name + " ")) missing += verb.name + " in fish\n";
    for (const FlagEntry& flag : verb.flags)
      for (const std::string& name : flag.names) {
        const bool word = name.starts_with("--");
        if (lacks(in_zsh, name + "[") && lacks(in_zsh, name + (word ? "=[" : "+[")))
          missing += verb.name + name + " in zsh\n";
        if (lacks(in_fish, (word ? " -l " + name.substr(2) : " -s " + name.substr(1)) + " "))
          missing += verb.name + name + " in fish\n";
      }
  }
  CHECK(missing.empty());
  CHECK_THAT(zsh, Catch::Contains(":(realtime fast balanced best)'"));
  for (const char* repeated : {"'*--set=[", "'*--point=["}) CHECK_THAT(zsh, Catch::Contains(repeated));
  CHECK_THAT(zsh, Catch::Contains("'(--preset)--preset=["));
  CHECK_THAT(zsh, Catch::Contains("'(-o --output)-o+["));  // -oFILE, too
  // Of a word that goes on without a blank, which zsh would put behind it.
  CHECK_THAT(zsh, Catch::Contains("NAME=VALUE:{compadd -S \"\" - "));
  CHECK_THAT(zsh, Catch::Contains(":{compadd - cpu vulkan; compadd -S \"\" - vulkan\\:}'"));
  CHECK_THAT(fish, Catch::Contains("-l preset -x -a 'realtime fast balanced best'"));
}

TEST_CASE("a completion for an unknown shell is refused by name") {
  const test::RanHere refused = test::ran_here({"completion", "tcsh"});
  CHECK(refused.exit_code == 2);
  CHECK(refused.err == "hdrcam: there is no completion for 'tcsh'; give bash, zsh or fish.\n");
}
