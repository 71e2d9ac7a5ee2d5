#include "firmware_host/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <ostream>
#include <string_view>
#include <vector>

#include "firmware_host/commands/command.h"
#include "firmware_host/exit_code.h"
#include "firmware_host/log_format.h"
#include "firmware_host/no_further_thread.h"
#include "firmware_host/noting_storage.h"
#include "firmware_host/printable.h"
#include "firmware_host/refused_words.h"
#include "firmware_host/settings/settings_flags.h"
#include "firmware_host/settings/suggestion.h"
#include "firmware_host/terminal.h"
#include "firmware_host/version.h"
#include "hal/core/cpu.h"

namespace hdrcam {
namespace {

// The verbs in the order in which --help lists them. Their one-line descriptions and flags live with them.
struct ListedVerb {
  const char* group;
  const char* name;
  void (*add)(CommandLine, Verb&);
  const char* example;
};
constexpr ListedVerb kVerbs[] = {
    {"HDR", "replay", add_replay, "hdrcam replay walk.mkv -o out/%06d.exr --report out/report.html"},
    {"HDR", "live", add_live, "hdrcam live --camera sim:walk --frames 90 -o out/%06d.exr"},
    {"HDR", "render", add_render, "hdrcam render walk.mkv --view 0.1,0,0 --speed 0.25 -o slow.mp4"},
    {"HDR", "encode", add_encode, "hdrcam encode out/%06d.exr -o walk.mp4"},
    {"HDR", "compare", add_compare, "hdrcam compare clips/walk out"},
    {"HDR", "bench", add_bench, "hdrcam bench pareto clips/walk -o cost"},
    {"Recordings", "record", add_record, "hdrcam record --shutter 1ms,4ms,16ms --frames 300 -o walk.mkv"},
    {"Recordings", "import", add_import, "hdrcam import clips/walk -o walk.mkv"},
    {"Recordings", "export", add_export, "hdrcam export walk.mkv -o frames"},
    {"Recordings", "info", add_info, "hdrcam info walk.mkv"},
    {"Recordings", "repair", add_repair, "hdrcam repair walk.mkv -o whole.mkv"},
    {"Recordings", "simulate", add_simulate, "hdrcam simulate walk -o walk.mkv --truth clips/walk"},
    {"Devices", "calibrate", add_calibrate, "hdrcam calibrate delay --camera /dev/video0 -o camera.toml"},
    {"Devices", "list", add_list, "hdrcam list"},
    {"Setup", "completion", add_completion, "hdrcam completion bash"},
    {"Setup", "manual", add_manual, "hdrcam manual -o man"},
};

constexpr const char* kAbout =
    "hdrcam turns a camera that alternates its exposure into an HDR video camera: frames come in short, "
    "medium and\n"
    "long in turn, and every one of them leaves as a scene-linear HDR frame of the same instant.";

std::string exit_code_text() {
  std::string text = "Exit codes:\n";
  for (const ExitCode& code : exit_codes()) text += fmt::format("  {:>3}  {}\n", code.number, code.meaning);
  return text;
}

std::string help_text(const CLI::App& app) {
  std::string text = app.get_description() +
                     "\n\nUsage: hdrcam VERB [flags]      hdrcam VERB --help      hdrcam --version\n";
  std::string_view group;
  for (const ListedVerb& verb : kVerbs) {
    if (group != verb.group) text += fmt::format("\n{}:\n", group = verb.group);
    text += fmt::format("  {:<11}{}\n             $ {}\n", verb.name,
                        app.get_subcommand(verb.name)->get_description(), verb.example);
  }
  text += "\n^C ends a run cleanly after the current frame; another ^C a moment later ends it at once.\n\n";
  return text + exit_code_text();
}

std::vector<std::string> verb_names() {
  std::vector<std::string> names{"help"};
  for (const ListedVerb& verb : kVerbs) names.emplace_back(verb.name);
  return names;
}

Error unknown_verb(std::string_view typed) {
  return {ErrorCode::Invalid, fmt::format("there is no verb '{}'{}; 'hdrcam --help' lists them", typed,
                                          did_you_mean(typed, verb_names()))};
}

Request to_print(std::string text) { return {.app = nullptr, .verb = {}, .text = std::move(text)}; }

// "hdrcam help [TOPIC]" prints what --help of that verb does. topics: "bench", or "bench", "kernels".
Result<Request> help_on(CLI::App& app, std::span<const char* const> topics) {
  const std::string_view topic = topics.empty() ? "help" : topics.front();
  const bool is_verb = topic != "help" && topic != "exit-codes";
  if (!is_verb && topics.size() > 1)
    return Error{ErrorCode::Invalid, fmt::format("unexpected argument '{}'; see 'hdrcam --help'", topics[1])};
  if (topic == "help") return to_print(help_text(app));
  if (topic == "exit-codes") return to_print(exit_code_text());
  if (const auto known = verb_names(); std::ranges::find(known, topic) == known.end())
    return unknown_verb(topic);
  const CLI::App* verb = app.get_subcommand(std::string(topic));
  std::string words = "hdrcam";
  for (const std::string_view inner : topics.subspan(1)) {
    words += ' ' + verb->get_name();
    const std::vector<const CLI::App*> verbs = verb->get_subcommands(nullptr);
    const auto found =
        std::ranges::find_if(verbs, [&](const CLI::App* known) { return known->get_name() == inner; });
    if (found == verbs.end())
      return Error{ErrorCode::Invalid,
                   fmt::format("unexpected argument '{}'; see '{} --help'", inner, words)};
    verb = *found;
  }
  return to_print(verb->help(words));
}

// One file of settings serves all verbs: a verb that uses no setting still checks the file. Not one with
// verbs of its own: before those the file would be checked and not used.
void add_config(CLI::App& verb, std::shared_ptr<SettingsFlags>& unused_settings) {
  if (verb.get_option_no_throw("--config") != nullptr || !verb.get_subcommands({}).empty()) return;
  auto flags = std::make_shared<SettingsFlags>(verb, std::vector<SettingGroup>{});
  verb.parse_complete_callback([flags, &unused_settings] { unused_settings = flags; });
}

std::shared_ptr<CLI::App> command_line(Verb& chosen, std::shared_ptr<SettingsFlags>& unused_settings) {
  auto app = std::make_shared<CLI::App>(kAbout, "hdrcam");
  app->require_subcommand(1);
  app->set_version_flag("--version", fmt::format("hdrcam {}", kVersion));
  for (const ListedVerb& verb : kVerbs) {
    verb.add(*app, chosen);
    CLI::App* added = app->get_subcommand(verb.name);
    added->group(verb.group);
    add_config(*added, unused_settings);
    added->footer(fmt::format("Example:\n  {}", verb.example));
  }
  return app;
}

bool takes_value(const CLI::App& verb, const std::string& flag) {
  const CLI::Option* option = verb.get_option_no_throw(flag);
  return option != nullptr && option->get_items_expected_max() > 0;
}

// The words as the parser takes them. CLI11 takes the word behind "--view=" for its value, which is empty,
// and "=x" for the value of "-o=x".
std::vector<std::string> words_of(const CLI::App& app, std::span<const char* const> args) {
  std::vector<std::string> words;
  const CLI::App* verb = &app;
  bool flags_may_follow = true;
  for (const std::string word : args) {
    for (const CLI::App* inner : verb->get_subcommands(nullptr))
      if (inner->get_name() == word) verb = inner;
    flags_may_follow &= word != "--";
    const std::size_t equals = word.find('=');
    const bool is_empty = word.starts_with("--") && equals + 1 == word.size(),
               is_short = word.starts_with('-') && equals == 2;
    if (flags_may_follow && (is_empty || is_short) && takes_value(*verb, word.substr(0, equals)))
      words.insert(words.end(), {word.substr(0, equals), word.substr(equals + 1)});
    else
      words.push_back(word);
  }
  return words;
}

// --log-format json on the command line holds from the first line on, also for what is wrong with the command
// line itself.
bool wants_json(std::span<const char* const> args) {
  constexpr std::string_view kFlag = "--log-format", kJson = "json";
  for (std::size_t i = 0; i < args.size(); ++i) {
    const std::string_view word = args[i];
    if (word == kFlag && i + 1 < args.size() && args[i + 1] == kJson) return true;
    if (word.starts_with(kFlag) && word.substr(kFlag.size()) == "=json") return true;
  }
  return false;
}

// code: errno of the write that failed, 0 where it is not known.
Error lost_output(int code, std::string_view consequence) {
  const char* const reason = code == EBADF   ? "it is closed"
                             : code == EPIPE ? "the program that reads it has ended"
                                             : std::strerror(code != 0 ? code : EIO);
  const bool full = code == ENOSPC || code == EDQUOT;
  return {full ? ErrorCode::NoSpace : ErrorCode::Io,
          fmt::format("cannot write to the standard output: {}{}", reason, consequence)};
}

Result<void> print(const std::string& text, std::ostream& out) {
  errno = 0;
  out << text << std::flush;
  return out ? Result<void>() : lost_output(errno, "");
}

// A run that failed leaves no empty folders that it made. Results that nobody got are an error, too.
Result<void> run_verb(const Verb& verb, Storage& storage, const std::atomic<bool>& stop) {
  NotingStorage noting(storage);
  Surroundings surroundings{noting, stop};
  Result<void> done = verb(surroundings);
  if (!done) {
    noting.remove_empty_folders();
    return done;
  }
  const int lost = lost_results();
  return lost == 0 ? Result<void>() : lost_output(lost, noting.written() ? "; the files are complete" : "");
}

}  // namespace

Result<Request> parse_command_line(std::span<const char* const> args) {
  Request request;
  std::shared_ptr<SettingsFlags> unused_settings;
  request.app = command_line(request.verb, unused_settings);
  CLI::App& app = *request.app;
  if (args.empty()) return Error{ErrorCode::Invalid, "no verb given; 'hdrcam --help' lists them"};
  const std::string_view first = args.front();
  if (first == "help") return help_on(app, args.subspan(1));
  const auto known = verb_names();
  if (!first.starts_with('-') && std::find(known.begin(), known.end(), first) == known.end())
    return unknown_verb(first);
  try {
    std::vector<std::string> words = words_of(app, args);
    std::ranges::reverse(words);  // as CLI11 wants them
    app.parse(std::move(words));
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app.get_subcommands();
    return to_print(chosen.empty() ? help_text(app) : chosen.front()->help("hdrcam"));
  } catch (const CLI::CallForVersion& version) {
    return to_print(std::string(version.what()) + '\n');
  } catch (const CLI::ParseError& refused) {
    return not_understood(app, refused);
  }
  if (unused_settings)
    request.verb = [unused_settings, verb = std::move(request.verb)](Surroundings& around) -> Result<void> {
      TRY(unused_settings->read(around.storage));
      return verb(around);
    };
  return request;
}

int run_program(std::span<const char* const> args, Storage& storage, const std::atomic<bool>& stop,
                std::ostream& out, std::ostream& err) {
  set_log_format(wants_json(args) ? LogFormat::Json : LogFormat::Text);
  const auto tell = [&](const std::string& sentence) {
    if (log_format() == LogFormat::Json)
      err << json_log_line(LogLevel::Error, sentence) << std::flush;
    else
      err << fmt::format("hdrcam: {}.\n", printable(sentence)) << std::flush;
  };
  const auto fail_internally = [&](const std::exception& bug) {
    tell(fmt::format("internal error: {}", bug.what()));
    return kExitInternal;
  };
  const auto end_with = [&](const Result<void>& done) {
    if (done) return kExitOk;
    tell(done.error().message);
    return exit_code_of(done.error().code);
  };
  try {
    auto request = parse_command_line(args);
    if (!request) return end_with(request.error());
    if (!request->verb) return end_with(print(request->text, out));
    if (const auto word = misnamed_instruction_set())
      return end_with(Error{ErrorCode::Invalid,
                            fmt::format("HDRCAM_ISA takes baseline, avx2 or avx512, not '{}'", *word)});
    return end_with(run_verb(request->verb, storage, stop));
  } catch (const std::system_error& refused) {
    if (refused.code() != std::errc::resource_unavailable_try_again) return fail_internally(refused);
    return end_with(no_further_thread());
  } catch (const std::bad_alloc&) {
    tell(
        "no memory is left; end other programs, raise the limit of memory (ulimit -v, or MemoryMax of a "
        "service), or give --preset fast or smaller pictures");
    return kExitInternal;
  } catch (const std::exception& bug) {
    return fail_internally(bug);
  }
}

}  // namespace hdrcam
