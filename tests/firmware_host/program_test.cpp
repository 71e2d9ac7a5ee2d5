#include "firmware_host/program.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "firmware_host/exit_code.h"
#include "firmware_host/version.h"
#include "hal/forwarding_storage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/ran_here.h"
#include "tests/support/refused_threads.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using Catch::Matches;
using test::ran_here;
using test::RanHere;

namespace {

// The words of a line as a shell would split them; no quotes.
std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

const std::vector<std::string> kVerbs{"replay", "live",   "render",     "encode", "compare",  "record",
                                      "import", "export", "info",       "repair", "simulate", "calibrate",
                                      "list",   "bench",  "completion", "manual"};

}  // namespace

TEST_CASE("--help names every verb with an example, and every exit code") {
  const RanHere help = ran_here({"--help"});
  CHECK(help.exit_code == kExitOk);
  CHECK(help.err.empty());
  for (const std::string& verb : kVerbs) CHECK_THAT(help.out, Contains("$ hdrcam " + verb));
  for (const ExitCode& code : exit_codes()) CHECK_THAT(help.out, Contains(code.meaning));
  CHECK(ran_here({"help"}).out == help.out);
  CHECK(ran_here({"help", "help"}).out == help.out);
}

TEST_CASE("the lines of --help fit on a terminal of 110 columns") {
  std::istringstream help(ran_here({"--help"}).out);
  for (std::string line; std::getline(help, line);) {
    INFO(line);
    CHECK(line.size() <= 110);
  }
}

TEST_CASE("every example of --help is a command line that the program accepts") {
  std::istringstream help(ran_here({"--help"}).out);
  int examples = 0;
  for (std::string line; std::getline(help, line);) {
    const auto words = words_of(line);
    if (words.size() < 2 || words[0] != "$") continue;
    std::vector<const char*> args;
    for (std::size_t i = 2; i < words.size(); ++i) args.push_back(words[i].c_str());
    const auto request = parse_command_line(args);
    INFO(line << (request.ok() ? "" : ": " + request.error().message));
    CHECK(request.ok());
    ++examples;
  }
  CHECK(examples == static_cast<int>(kVerbs.size()));
}

TEST_CASE("a verb explains its flags, whichever way it is asked") {
  for (const std::string& verb : kVerbs) {
    const RanHere flag = ran_here({verb, "--help"});
    CHECK(flag.exit_code == kExitOk);
    CHECK_THAT(flag.out, Contains("Usage: hdrcam " + verb) && Contains("Example:"));
    CHECK(ran_here({"help", verb}).out == flag.out);
  }
}

TEST_CASE("help explains a verb of a verb") {
  const RanHere help = ran_here({"help", "bench", "kernels"});
  CHECK(help.exit_code == kExitOk);
  CHECK_THAT(help.out, Contains("Usage: hdrcam bench kernels"));
  CHECK(help.out == ran_here({"bench", "kernels", "--help"}).out);
  const RanHere unknown = ran_here({"help", "bench", "paretto"});
  CHECK(unknown.exit_code == kExitUsage);
  CHECK_THAT(unknown.err, Contains("unexpected argument 'paretto'; see 'hdrcam bench --help'"));
  for (const char* topic : {"help", "exit-codes", "info"}) {
    const RanHere beyond = ran_here({"help", topic, "walk.mkv"});
    CHECK(beyond.exit_code == kExitUsage);
    CHECK_THAT(beyond.err, Contains("unexpected argument 'walk.mkv'"));
  }
}

TEST_CASE("the help of a verb lists no flag that it never takes") {
  const auto lacks = [](const std::vector<std::string>& verb, const std::vector<std::string>& flags) {
    std::vector<std::string> words = verb;
    words.emplace_back("--help");
    const std::string help = ran_here(words).out;
    for (const std::string& flag : flags)
      CHECK_THAT(help, Contains("Configuration:") && !Contains(flag + " TEXT"));
  };
  lacks({"render"}, {"--snapshot", "--flow-forward", "--flow-backward", "--field-flow-forward",
                     "--field-flow-backward", "--http-record"});
  lacks({"replay"}, {"--http-record"});
  lacks({"bench", "pareto"}, {"--trace"});
  lacks({"calibrate"}, {"--adapt", "--pace"});
}

TEST_CASE("the help of a camera's verbs explains the frame rate without another verb") {
  for (const char* verb : {"live", "record", "calibrate"})
    CHECK_THAT(ran_here({verb, "--help"}).out, Contains("frames per second of the camera, or of files"));
}

TEST_CASE("the help of render says how a film numbers its frames") {
  CHECK_THAT(ran_here({"render", "--help"}).out,
             Contains("HDR frames, numbered from 0: out/%06d.exr") && !Contains("the sensor's sequence"));
  CHECK_THAT(ran_here({"replay", "--help"}).out, Contains("numbered by the sensor's sequence"));
}

TEST_CASE("the help of render names no motion among the channels, which it refuses") {
  CHECK_THAT(ran_here({"render", "--help"}).out,
             Contains("any of depth,confidence,provenance") && !Contains("flow"));
  CHECK_THAT(ran_here({"replay", "--help"}).out, Contains("any of depth,flow,flow_forward"));
}

TEST_CASE("--version is one line") {
  const RanHere version = ran_here({"--version"});
  CHECK(version.exit_code == kExitOk);
  CHECK(version.out == std::string("hdrcam ") + kVersion + "\n");
}

TEST_CASE("help exit-codes lists them alone") {
  const RanHere codes = ran_here({"help", "exit-codes"});
  CHECK(codes.exit_code == kExitOk);
  CHECK_THAT(codes.out, Contains(" 11  the disk or quota is full") && !Contains("Usage"));
}

TEST_CASE("what is not understood is named in one sentence, with the nearest known word") {
  const auto refused = [](const std::vector<std::string>& words) {
    const RanHere result = ran_here(words);
    CHECK(result.exit_code == kExitUsage);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, Matches("hdrcam: [^\n]*\\.\n"));
    return result.err;
  };
  CHECK_THAT(refused({}), Contains("no verb"));
  CHECK_THAT(refused({"repaly", "walk.mkv"}), Contains("'repaly'") && Contains("did you mean 'replay'?"));
  CHECK_THAT(refused({"levitate"}), Contains("'levitate'") && !Contains("did you mean"));
  CHECK_THAT(refused({"help", "exprot"}), Contains("'exprot'") && Contains("did you mean 'export'?"));
  CHECK_THAT(refused({"replay", "walk.mkv", "--ouptut", "x"}),
             Contains("'--ouptut'") && Contains("'--output'"));
  CHECK_THAT(refused({"replay", "--seeed=4"}), Contains("'--seeed'") && Contains("'--seed'"));
  CHECK_THAT(refused({"--verbos"}), Contains("'--verbos'") && Contains("hdrcam --help"));
  CHECK_THAT(refused({"replay", "walk.mkv", "--seed", "many"}), Contains("--seed") && Contains("many"));
  CHECK_THAT(refused({"info"}), Contains("hdrcam info --help"));
  CHECK(refused({"compare", "clip"}) == "hdrcam: no OUT given; see 'hdrcam compare --help'.\n");
  CHECK_THAT(refused({"compare"}), Contains("no CLIP given"));
  CHECK_THAT(refused({"encode", "-o", "x.mp4"}), Contains("no frames given"));  // of which there are many
  CHECK_THAT(refused({"repair", "walk.mkv"}), Contains("--output is required"));
  CHECK_THAT(refused({"replay", "walk.mkv", "--stats", "a", "--stats", "b"}),
             Contains("--stats is given twice; give it once"));
  CHECK_THAT(refused({"record", "--trigger-gap", "1ms", "--trigger-gap", "1ms", "--trigger-gap", "1ms"}),
             Contains("--trigger-gap is given 3 times; give it once"));
  CHECK_THAT(refused({"bench", "kernels", "--config", "c.toml"}),
             Contains("unknown flag '--config'") && !Contains("mean '--config'") &&
                 Contains("'hdrcam bench kernels --help'"));
  CHECK_THAT(refused({"bench", "pareto"}), Contains("'hdrcam bench pareto --help'"));
  CHECK(refused({"bench"}) == "hdrcam: bench needs 'kernels' or 'pareto'; see 'hdrcam bench --help'.\n");
  CHECK_THAT(refused({"bench", "--config", "c.toml", "pareto", "clip", "-o", "cost"}),
             Contains("flag '--config' belongs behind 'hdrcam bench pareto'"));
  CHECK_THAT(refused({"bench", "--seconds", "1", "kernels"}),
             Contains("flag '--seconds' belongs behind 'hdrcam bench kernels'"));
  CHECK_THAT(refused({"--preset", "fast", "replay", "walk.mkv"}),
             Contains("flag '--preset' belongs behind 'hdrcam replay'"));
  CHECK_THAT(refused({"bench", "paretto"}), Contains("'paretto' (did you mean 'pareto'?)"));
  CHECK_THAT(refused({"live", "sim:walk"}), Contains("'sim:walk' (did you mean '--camera sim:walk'?)"));
  CHECK_THAT(refused({"record", "/dev/video0", "-o", "walk.mkv"}), Contains("'--camera /dev/video0'"));
  CHECK_THAT(refused({"live", "walk.mkv"}),
             Contains("'walk.mkv' (did you mean '--camera replay:walk.mkv'?)"));
  CHECK_THAT(refused({"calibrate", "delay", "walk.mkv"}), !Contains("did you mean"));
  CHECK_THAT(refused({"list", "sim:walk"}), Contains("'sim:walk'") && !Contains("did you mean"));
  CHECK_THAT(refused({"repair", "walk.mkv", "--shutter", "1ms"}),
             Contains("unknown flag '--shutter' (a flag of ") && Contains("record") && Contains("import"));
  CHECK_THAT(refused({"replay", "walk.mkv", "--seconds", "1"}),
             Contains("unknown flag '--seconds' (a flag of bench kernels)"));
  CHECK_THAT(refused({"bench", "kernels", "--point", "fast"}), Contains("(a flag of bench pareto)"));
}

TEST_CASE("a file whose name begins as a flag does is told apart, and how it is named") {
  const std::string file = "-refused_words_test.mkv";  // of this folder: a path with folders is no flag
  std::ofstream(file) << "";
  const std::string told = ran_here({"info", file}).err;
  std::filesystem::remove(file);
  CHECK_THAT(told, Contains("unknown flag '" + file + "' (the file is named as './" + file + "')"));
  CHECK_THAT(ran_here({"info", file}).err, Contains("unknown flag") && !Contains("the file is"));
}

TEST_CASE("'-' in the place of what is read is refused: nobody reads the standard input") {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"replay", "-", "-o", "x.mp4"},
                                                {"render", "-", "-o", "x.mp4"},
                                                {"info", "-"},
                                                {"export", "-", "-o", "x"},
                                                {"repair", "-", "-o", "x.mkv"},
                                                {"import", "-", "-o", "x.mkv"},
                                                {"encode", "-", "-o", "x.mp4"}}) {
    const RanHere run = ran_here(words);
    CHECK(run.exit_code == kExitUsage);
    CHECK_THAT(run.err, Contains("takes the name of a file, not '-': the standard input is not read"));
  }
}

TEST_CASE("a flag whose value is empty behind its equals sign takes no other word for it") {
  const auto told = [](const std::vector<std::string>& words) { return ran_here(words).err; };
  CHECK_THAT(told({"render", "no.mkv", "--view=", "-o", "o/%06d.exr"}), Contains("'no.mkv' does not exist"));
  CHECK_THAT(told({"replay", "--stats=", "no.mkv", "-o", "o/%06d.exr"}),
             Contains("--stats takes the name of a file or a folder, not ''"));
  CHECK_THAT(told({"simulate", "--frames=", "walk"}),
             Contains("--frames takes a whole number, 1 to 1000000, not ''"));
  CHECK_THAT(told({"replay", "no.mkv", "--set=", "steps=0"}), Contains("unexpected argument 'steps=0'"));
  CHECK_THAT(told({"bench", "pareto", "noclip", "--output=", "o"}),
             Contains("--output takes the name of a file or a folder, not ''"));
  CHECK_THAT(told({"replay", "no.mkv", "--viw=", "-o", "o/%06d.exr"}), Contains("unknown flag '--viw'"));
  CHECK_THAT(told({"info", "--json=", "no.mkv"}), Contains("'no.mkv' does not exist"));  // a switch
  CHECK_THAT(told({"info", "--", "--stats="}), Contains("'--stats=' does not exist"));
}

TEST_CASE("a short flag takes its value behind an equals sign, too") {
  const std::string recording = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
  CHECK_THAT(ran_here({"replay", recording, "-o=frames.jpg"}).err,
             Contains("'frames.jpg'") && !Contains("'=frames.jpg'"));
  CHECK_THAT(ran_here({"replay", recording, "-o=a=b.jpg"}).err, Contains("'a=b.jpg'"));
  CHECK_THAT(ran_here({"export", recording, "-o="}).err,
             Contains("--output takes the name of a file or a folder, not ''"));
  CHECK_THAT(ran_here({"info", "-o=x", "no.mkv"}).err, Contains("unknown flag '-o'"));
  CHECK_THAT(ran_here({"info", "--", "-o=x"}).err, Contains("'-o=x' does not exist"));
}

TEST_CASE("the mark that ends the flags is not called an unknown one") {
  CHECK_THAT(ran_here({"info", "--"}).err, Contains("no recording given; see 'hdrcam info --help'"));
  CHECK_THAT(ran_here({"repair", "--", "no.mkv"}).err, Contains("--output is required; see 'hdrcam repair"));
  CHECK_THAT(ran_here({"--"}).err, Contains("no verb given; see 'hdrcam --help'"));
  CHECK_THAT(ran_here({"info", "--", "no.mkv", "other.mkv"}).err,
             Contains("unexpected argument 'other.mkv'"));
}

TEST_CASE("a flag that may be repeated takes one word each time, and the word behind it is an argument") {
  const RanHere replay =
      ran_here({"replay", "--set", "steps=0", "no.mkv", "-o", "o/%06d.exr", "--set=hidden=8"});
  CHECK_THAT(replay.err, Contains("'no.mkv' does not exist"));
  const RanHere bench =
      ran_here({"bench", "pareto", "--point", "fast", "noclip", "-o", "o", "--point", "best"});
  CHECK_THAT(bench.err, Contains("'noclip"));
  CHECK(ran_here({"replay", "no.mkv", "-o", "o/%06d.exr", "--set", "steps=0", "hidden=8"}).exit_code ==
        kExitUsage);
}

TEST_CASE("a value that is missing or no number is told with its flag and what the flag takes") {
  const auto refused = [](const std::vector<std::string>& words) {
    const RanHere result = ran_here(words);
    CHECK(result.exit_code == kExitUsage);
    return result.err.substr(0, result.err.find("; see "));
  };
  CHECK(refused({"replay", "walk.mkv", "--preset"}) == "hdrcam: --preset needs a value");
  CHECK(refused({"replay", "walk.mkv", "-o"}) == "hdrcam: --output needs a value");
  CHECK(refused({"render", "walk.mkv", "--speed", "25%"}) == "hdrcam: --speed takes a number, not '25%'");
  for (const std::string flag : {"--speed", "--framerate", "--shutter-angle"})  // "" was 0
    CHECK(refused({"render", "walk.mkv", flag, ""}) == "hdrcam: " + flag + " takes a number, not ''");
  for (const std::string skip : {"x", "", "99999999999"})  // "": $SKIP where it is not set, which was 0
    CHECK(refused({"compare", "clip", "out", "--skip", skip}) ==
          "hdrcam: --skip takes a whole number, 0 to 1000000, not '" + skip + "'");
  CHECK(refused({"simulate", "walk", "--frames", "0"}) ==
        "hdrcam: --frames takes a whole number, 1 to 1000000, not '0'");
  CHECK(refused({"simulate", "walk", "--bits", "0"}) ==
        "hdrcam: --bits takes a whole number, 8 to 16, not '0'");
  CHECK(refused({"live", "--frames", "-3"}) ==
        "hdrcam: --frames takes a number of frames, 1 to 1000000000, not '-3'");
  CHECK(refused({"info", "walk.mkv", "--json=maybe"}) == "hdrcam: --json takes true or false, not 'maybe'");
}

TEST_CASE(
    "a flag for a number takes decimal digits, with or without zeros before them, and no other notation") {
  const std::string frames = sample::scratch_folder("numbers") + "/%06d.exr";
  for (const char* word : {"0x5", "+5", " 5"}) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"record", "-o", "x.mkv", "--timeout"},
          {"record", "-o", "x.mkv", "--frames"},
          {"record", "-o", "x.mkv", "--width"},
          {"simulate", "walk", "-o", "x.mkv", "--frames"},
          {"compare", "clip", "out", "--skip"},
          {"bench", "kernels", "--seconds"},
          {"render", "walk.mkv", "-o", frames, "--speed"}}) {
      std::vector<std::string> with = words;
      with.emplace_back(word);
      const RanHere refused = ran_here(with);
      INFO(words.front() << ' ' << words.back() << ' ' << word);
      CHECK(refused.exit_code == kExitUsage);
      CHECK_THAT(refused.err, Contains(words.back() + " takes ") && Contains(fmt::format("not '{}'", word)));
    }
  }
  const std::string recording = sample::scratch_folder("ten_frames") + "/x.mkv";
  REQUIRE(ran_here({"simulate", "still?size=64x48", "--frames", "010", "-o", recording}).exit_code ==
          kExitOk);
  CHECK(open_recording(posix_storage(), recording).value()->frame_count() == 10);  // not eight
}

TEST_CASE("the settings are printed without what a run needs") {
  for (const std::vector<std::string>& verb : {std::vector<std::string>{"encode"},
                                               {"import"},
                                               {"export"},
                                               {"repair"},
                                               {"calibrate"},
                                               {"replay"},
                                               {"bench", "pareto"}}) {
    std::vector<std::string> words = verb;
    words.emplace_back("--print-config");
    const RanHere printed = ran_here(words);
    INFO(verb.back() << ": " << printed.err);
    CHECK(printed.exit_code == kExitOk);
    CHECK(printed.err.empty());
  }
  CHECK(ran_here({"encode"}).exit_code == kExitUsage);
  const RanHere not_printed = ran_here({"encode", "--print-config=false"});
  CHECK(not_printed.exit_code == kExitUsage);
  CHECK(not_printed.out.empty());
}

TEST_CASE("a number that cannot be is refused with the range that a person needs, NaN always") {
  const auto refused = [](const std::vector<std::string>& words) {
    const RanHere result = ran_here(words);
    CHECK(result.exit_code == kExitUsage);
    return result.err;
  };
  CHECK_THAT(refused({"replay", "walk.mkv", "--frames", "0"}),
             Contains("--frames") && Contains("1 to 1000000000") && Contains("'0'"));
  CHECK_THAT(refused({"record", "--frames", "-3"}), Contains("1 to 1000000000"));
  CHECK_THAT(refused({"record", "--timeout", "0"}), Contains("more than 0") && !Contains("e+308"));
  CHECK_THAT(refused({"record", "--timeout", "5000000000"}), Contains("at most 1000000000 (30 years)"));
  CHECK_THAT(refused({"record", "--timeout", "-1s"}), Contains("not '-1s'"));      // as it was written
  CHECK_THAT(refused({"record", "--timeout", "1e-10"}), Contains("more than 0"));  // it would be no limit
  for (const char* none : {"nan", "-nan", "inf"}) {
    CHECK_THAT(refused({"record", "--timeout", none}), Contains("seconds"));
    CHECK_THAT(refused({"replay", "walk.mkv", "-o", "%06d.exr", "--code-noise", none}),
               Contains("--code-noise") && Contains("0..20"));
    CHECK_THAT(refused({"live", "--framerate", none}), Contains("--framerate"));
    CHECK_THAT(refused({"live", "--camera", "sim:still", "--shutter", none}), Contains(none));
    CHECK_THAT(refused({"live", "--camera", "sim:still", "--gain", none}), Contains(none));
    CHECK_THAT(
        refused({"replay", "walk.mkv", "-o", "%06d.exr", "--set", std::string("state.blur_weight=") + none}),
        Contains("state.blur_weight"));
    CHECK(ran_here({"simulate", std::string("walk?fps=") + none, "-o", "x.mkv"}).exit_code == kExitUsage);
  }
}

TEST_CASE("a file where a folder belongs, no calibration, and a recording as settings are wrong arguments") {
  const std::string recording = HDRCAM_SOURCE_DIR "/tests/data/demo.mkv";
  const auto refused = [](const std::vector<std::string>& words) {
    const RanHere result = ran_here(words);
    CHECK(result.exit_code == kExitUsage);
    return result.err;
  };
  CHECK_THAT(refused({"export", recording, "-o", recording}),
             Contains("is a file; --output names the folder"));
  CHECK_THAT(refused({"compare", recording, "."}), Contains("is a file; name a clip with clip.json"));
  CHECK_THAT(refused({"bench", "pareto", recording, "-o", "cost"}),
             Contains("is a file; name a clip with clip.json"));
  CHECK_THAT(refused({"replay", recording, "-o", "out/%06d.exr", "--truth", recording}),
             Contains("is a file; name a clip with clip.json"));
  CHECK_THAT(refused({"compare", ".", recording}), Contains("is a file; name the folder"));
  CHECK_THAT(refused({"calibrate"}), Contains("give 'hdrcam calibrate delay'"));
  CHECK_THAT(refused({"replay", recording, "--config", recording}), Contains("is not a file of settings"));
}

TEST_CASE("--timeout takes a duration as well as a number of seconds") {
  for (const char* timeout : {"2000ms", "2s", "2"})  // refused for what comes later
    CHECK_THAT(ran_here({"record", "--camera", "sim:nosuch", "--timeout", timeout, "-o", "x.mkv"}).err,
               Contains("nosuch"));
  CHECK_THAT(ran_here({"record", "--help"}).out, Contains("--timeout TEXT") && !Contains("--timeout FLOAT"));
  CHECK_THAT(ran_here({"record", "--timeout", "2h"}).err,
             Contains("takes a duration such as 90s") && Contains("'2h'"));
}

TEST_CASE("an error cannot move the cursor of a terminal") {
  const RanHere missing = ran_here({"info", "/no/\x1b[2Jsuch.mkv"});
  CHECK(missing.err.find('\x1b') == std::string::npos);
  CHECK_THAT(missing.err, Contains("/no/\\u001B[2Jsuch.mkv"));
}

TEST_CASE("an error of a verb is one sentence with the exit code of its kind") {
  const RanHere missing = ran_here({"info", "/no/such/recording.mkv"});
  CHECK(missing.exit_code == exit_code_of(ErrorCode::NotFound));
  CHECK_THAT(missing.err, Matches("hdrcam: [^\n]*/no/such/recording.mkv[^\n]*\\.\n"));
}

TEST_CASE("a thread that the system does not start is called so, and no bug of the program") {
  const std::string folder = sample::scratch_folder("program_threads");
  const std::vector<std::string> replay{"replay", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv", "-o",
                                        folder + "/%06d.exr"},
      record{"record", "--camera",         "sim:still?size=64x48&fps=50", "--shutter", "1ms,4ms",
             "-o",     folder + "/raw.mkv"};
  std::vector<std::string> triggered = record;
  triggered.insert(triggered.end(), {"--trigger-line", "sim", "--trigger", "fsync"});
  const test::RefusedThreads refused;
  for (const auto& words : {replay, record, triggered}) {
    CAPTURE(words);
    const RanHere run = ran_here(words);
    CHECK(run.exit_code == exit_code_of(ErrorCode::Io));
    CHECK_THAT(run.err, Contains("starts no further thread") && Contains("ulimit -u"));
  }
  CHECK(std::filesystem::is_empty(folder));
}

TEST_CASE("an instruction set that does not exist is refused, as the run would not be the one asked for") {
  const char* const before = std::getenv("HDRCAM_ISA");
  const std::string kept = before == nullptr ? "" : before;
  const std::vector<std::string> info{"info", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv"};
  REQUIRE(setenv("HDRCAM_ISA", "basline", 1) == 0);
  const RanHere misnamed = ran_here(info);
  REQUIRE(setenv("HDRCAM_ISA", "baseline", 1) == 0);
  const RanHere named = ran_here(info);
  REQUIRE((before == nullptr ? unsetenv("HDRCAM_ISA") : setenv("HDRCAM_ISA", kept.c_str(), 1)) == 0);
  CHECK(misnamed.exit_code == kExitUsage);
  CHECK_THAT(misnamed.err, Contains("HDRCAM_ISA takes baseline, avx2 or avx512, not 'basline'"));
  CHECK(named.exit_code == kExitOk);
}

TEST_CASE("a lack of memory is called so, and no internal error") {
  struct FullMemory : ForwardingStorage {
    using ForwardingStorage::ForwardingStorage;
    Result<std::unique_ptr<StorageFile>> open(const std::string&) override { throw std::bad_alloc(); }
  };
  FullMemory full(posix_storage());
  const RanHere run = ran_here({"info", HDRCAM_SOURCE_DIR "/tests/data/demo.mkv"}, full);
  CHECK(run.exit_code == kExitInternal);
  CHECK_THAT(run.err, Contains("no memory is left") && !Contains("internal error"));
}

TEST_CASE("the installed program behaves as the one in this process") {
  const int status = std::system("'" HDRCAM_BINARY "' no-such-verb 2>/dev/null");
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == kExitUsage);
}
