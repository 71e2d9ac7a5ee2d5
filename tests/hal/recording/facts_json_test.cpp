#include "hal/recording/facts_json.h"

#include <string>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

// The facts of a frame with one member as given.
std::string facts_with(const std::string& member, const std::string& value) {
  std::string text = to_json(3, FrameFacts{}, 8);
  const std::size_t key = text.find('"' + member + "\":");
  REQUIRE(key != std::string::npos);
  const std::size_t begin = key + member.size() + 3;
  return text.replace(begin, text.find_first_of(",}", begin) - begin, value);
}

TEST_CASE(
    "a fact that must be a whole number is refused where it is none or out of range, and never converted") {
  CHECK(record_from_json(facts_with("index", "7"), 8).ok());
  for (const char* member : {"index", "sequence", "timestamp_ns", "slot", "flags"})
    for (const char* value : {"6.66e37", "1.5", "1e99", "true", "\"7\"", "99999999999999999999"}) {
      INFO(member << ' ' << value);
      require_error(record_from_json(facts_with(member, value), 8), ErrorCode::Corrupt);
    }
  require_error(record_from_json(facts_with("sequence", "-1"), 8), ErrorCode::Corrupt);
  require_error(record_from_json(facts_with("slot", "4294967296"), 8), ErrorCode::Corrupt);
  require_error(record_from_json(facts_with("flags", "4294967296"), 8), ErrorCode::Corrupt);
}

TEST_CASE(
    "facts that cannot be read are called by what is wrong with them, without the words of the library") {
  const auto says = [](const auto& read, const std::string& wanted) {
    REQUIRE_FALSE(read.ok());
    INFO(read.error().message);
    CHECK(read.error().message.ends_with(wanted));
    CHECK(read.error().message.find("exception") == std::string::npos);
  };
  says(record_from_json("{}", 8), "the facts of a frame cannot be read: key 'index' not found");
  says(record_from_json(facts_with("slot", "[[1], 2]"), 8),
       ": [[1],2] where a whole number within its range is needed");
  says(camera_from_json(R"({"format":"hdrcam recording","version":1})"),
       "the camera facts cannot be read: key 'name' not found");
  says(camera_from_json(R"({"format":"hdrcam recording","version":1,"name":3})"),
       "the camera facts cannot be read: type must be string, but is number");
}

TEST_CASE("facts that nest without end are refused without running out of stack") {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  require_error(record_from_json(facts_with("slot", deep), 8), ErrorCode::Corrupt);
  require_error(record_from_json(R"({"index":)" + deep + "}", 8), ErrorCode::Corrupt);
  require_error(camera_from_json(R"({"format":"hdrcam recording","version":)" + deep + "}"),
                ErrorCode::Corrupt);
}

// As files of before November 2026 have it: without verdict, estimate and white balance.
constexpr const char* kEarlyFacts =
    R"({"index":3,"sequence":4,"timestamp_ns":100000000,"exposure_s":0.004,"analogue_gain":2.0,"digital_gain":1.0,)"
    R"("slot":1,"black_level":16.0,"exposure_source":"photometric","flags":0})";
constexpr const char* kEarlyCamera =
    R"({"format":"hdrcam recording","version":1,"name":"x","width":64,"height":48,"framerate_hz":30.0,"bits":8,)"
    R"("layout":"rgb","linear":false})";

TEST_CASE("a recording of an earlier version reads as it did") {
  const auto early = record_from_json(kEarlyFacts, 8);
  REQUIRE(early.ok());
  CHECK(early.value().facts.exposure_source == ExposureSource::Photometric);
  CHECK_FALSE(early.value().facts.verdict);
  CHECK(early.value().facts.has_exposure_time());
  CHECK(early.value().facts.exposure() == 0.008);
  const auto camera = camera_from_json(kEarlyCamera);
  REQUIRE(camera.ok());
  CHECK_FALSE(camera.value().white_balance);
  CHECK_FALSE(camera.value().turned_upright);
  CHECK(to_json(3, early.value().facts, 8) == kEarlyFacts);  // and is written as it was
  CHECK(to_json(camera.value(), RecordingCodec::Ffv1) == kEarlyCamera);
}

TEST_CASE("a newer version of a recording is refused by its number, and keys that nobody knows are ignored") {
  const std::string text = to_json(camera_from_json(kEarlyCamera).value(), RecordingCodec::Huffyuv),
                    stated = "\"version\":2";
  const std::size_t at = text.find(stated);
  REQUIRE(at != std::string::npos);  // with FFV1 it is 1, as above
  CHECK(camera_from_json(text).ok());
  std::string newer = text;
  const auto refused = camera_from_json(newer.replace(at, stated.size(), "\"version\":3"));
  require_error(refused, ErrorCode::Unsupported);
  CHECK(refused.error().message.find("version 3, this program reads up to 2") != std::string::npos);

  const auto with_more = [](std::string known) { return known.insert(1, R"("lens_maker":{"name":["x"]},)"); };
  const auto camera = camera_from_json(with_more(text));
  REQUIRE(camera.ok());
  CHECK(to_json(camera.value(), RecordingCodec::Huffyuv) == text);
  const auto frame = record_from_json(with_more(kEarlyFacts), 8);
  REQUIRE(frame.ok());
  CHECK(to_json(3, frame.value().facts, 8) == kEarlyFacts);
}

TEST_CASE("every source and verdict has one word, which reads back as itself") {
  for (const ExposureSource source : kExposureSources)
    for (const Verdict verdict : kVerdicts) {
      FrameFacts facts;
      facts.exposure_source = source, facts.verdict = verdict;
      const auto read = record_from_json(to_json(0, facts, 8), 8);
      REQUIRE(read.ok());
      CHECK(read.value().facts.exposure_source == source);
      CHECK(read.value().facts.verdict == verdict);
    }
  require_error(record_from_json(facts_with("exposure_source", "\"guessed\""), 8), ErrorCode::Corrupt);
}

}  // namespace
}  // namespace hdrcam
