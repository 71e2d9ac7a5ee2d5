#include "firmware_host/sinks/report.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "firmware_host/sinks/svg_chart.h"
#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/firmware_host/sinks/example_run.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

// The first thing that is wrong with the tags of an HTML text, "" if they are balanced. Void elements have no
// end tag, the content of <style> is not looked into, and '<' in text must be written as an entity.
std::string unbalanced(const std::string& html) {
  const std::set<std::string> voids{"meta", "img", "br", "!DOCTYPE"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "a tag without '>'";
    const std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return "'<' inside of " + tag;
    const bool closing = tag.starts_with('/');
    const std::string name = tag.substr(closing, tag.find_first_of(" /\n", closing) - closing);
    if (name.empty()) return "a tag without a name";
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return "an open quote in " + tag;
    if (closing) {
      if (open.empty() || open.back() != name)
        return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
      open.pop_back();
    } else if (!tag.ends_with('/') && !voids.contains(name)) {
      open.push_back(name);
    }
    at = name == "style" && !closing ? html.find("</style>", end) : end;
  }
  return open.empty() ? "" : open.back() + " is never closed";
}

}  // namespace

TEST_CASE("the checker of tags finds what is wrong") {
  CHECK(unbalanced("<p>a<br></p>").empty());
  CHECK(unbalanced("<svg><line x=\"1\"/></svg>").empty());
  CHECK_FALSE(unbalanced("<p>a").empty());
  CHECK_FALSE(unbalanced("<p><b></p></b>").empty());
  CHECK_FALSE(unbalanced("<p>1 < 2</p>").empty());
  CHECK_FALSE(unbalanced("<p class=\"a></p>").empty());
}

TEST_CASE("the report is one well-formed page that needs nothing else") {
  const std::string html = report_html(test::example_run(48), bytes_of("not really a picture"));
  CHECK(unbalanced(html).empty());
  CHECK(html.starts_with("<!DOCTYPE html>"));
  for (const char* outside : {"http:", "https:", "<script", "<link", "@import", "url("}) {
    INFO(outside);
    CHECK(html.find(outside) == std::string::npos);
  }
}

TEST_CASE("the report holds every part of the run") {
  const std::string html = report_html(test::example_run(48), bytes_of("picture"));
  for (const char* part :
       {"hdrcam replay walk.mkv", "balanced", "0.1.0", "kernels", "data:image/png;base64,cGljdHVyZQ==",
        "photometric", "smoothness", "prior mean", "deadline 100.0 ms", "95th percentile",
        "mean over the steps at its frame", "emission", "look-ahead", "PSNR-mu", "38.1 dB", "0.059 stops",
        "48 captured = 48 emitted + 0 dropped", "no poses are tracked", "frame 5: a step was rolled back"}) {
    INFO(part);
    CHECK(html.find(part) != std::string::npos);
  }
}

TEST_CASE("text of the user is escaped") {
  const std::string html = report_html(test::example_run(2), {});
  CHECK_THAT(html, Contains("walk &lt;demo&gt; &amp; more") && !Contains("<demo>"));
  CHECK(escaped("a\"b'c") == "a&quot;b&#39;c");
}

TEST_CASE("a name that is not UTF-8 is shown with a mark in its place, so that the page is UTF-8") {
  RunRecord record = test::example_run(2);
  record.title = "caf\xe9.mkv";
  const std::string html = report_html(record, {});
  CHECK_THAT(html, Contains("caf\ufffd.mkv") && !Contains("\xe9"));
  CHECK(escaped("café <ü>") == "café &lt;ü&gt;");
  CHECK(escaped("a\nb\t\\\"") == "a\nb\t\\&quot;");
}

TEST_CASE("frames that do not add up are shown in red") {
  RunRecord record = test::example_run(8);
  record.captured = 10, record.dropped = 1;
  CHECK_THAT(report_html(record, {}), Contains("class=\"bad\">10 captured &ne; 8 emitted + 1 dropped"));
}

TEST_CASE("the share of frames within the deadline is that of the frames that are not counted as late") {
  RunRecord record = test::example_run(18);
  record.frames.front().total_ms = 9 * record.deadline_ms;  // of the first ones, worked on at once
  record.captured = 20, record.dropped = 2;
  record.left_out = 2;
  record.late = 5;
  CHECK_THAT(report_html(record, {}),
             Contains("\"bad\">75 <small>%</small></b><span>of frames within 100.0 ms"));
  record.late = 0;
  CHECK_THAT(report_html(record, {}),
             Contains("\"good\">100 <small>%</small></b><span>of frames within 100.0 ms"));
}

TEST_CASE("a run without frames, scores, response or picture still has a page") {
  const std::string html = report_html(RunRecord{}, {});
  CHECK(unbalanced(html).empty());
  CHECK_THAT(html, !Contains("nan") && !Contains("<svg") && !Contains("<img"));
}

TEST_CASE("holes and wild values do not reach the page as 'nan' or 'inf'") {
  RunRecord record = test::example_run(30);
  record.frames[3].losses[0].value = NAN;
  record.frames[4].losses[1].value = INFINITY;
  record.frames[5].losses[1].value = -1;
  record.frames[7].stages_ms.clear();
  const std::string html = report_html(record, {});
  CHECK(unbalanced(html).empty());
  for (const char* wild : {"nan", "inf"})
    for (std::size_t at = html.find(wild); at != std::string::npos; at = html.find(wild, at + 1)) {
      INFO(html.substr(at - std::min<std::size_t>(at, 40), 60));
      CHECK(std::isalpha(static_cast<unsigned char>(html[at + 3])) != 0);  // of a word, as in "info"
    }
}

TEST_CASE("the page of a long run is not much larger than that of a short one") {
  CHECK(report_html(test::example_run(20000), {}).size() < 200'000);
}

TEST_CASE("a bar of several frames is their mean time, also where a stage did not run in all of them") {
  // every second frame 10 ms, or each one 5
  const auto time_chart = [](double even_ms, double odd_ms) {
    RunRecord record = test::example_run(480);
    for (std::size_t i = 0; i < record.frames.size(); ++i) {
      record.frames[i].stages_ms = {{"flow", 10}};
      if (const double ms = i % 2 == 0 ? even_ms : odd_ms; ms > 0)
        add_to(record.frames[i].stages_ms, {"noise", ms});
    }
    const std::string html = report_html(record, {});
    const std::size_t begin = html.find("<figure");
    return html.substr(begin, html.find("</figure>") - begin);
  };
  CHECK_THAT(time_chart(5, 5), Contains("<title>noise</title>"));
  CHECK(time_chart(10, 0) == time_chart(5, 5));
}

TEST_CASE("ticks are round and lie within the axis") {
  CHECK(round_ticks(0, 10, 5) == std::vector<double>{0, 2, 4, 6, 8, 10});
  CHECK(round_ticks(-12, 0, 5) == std::vector<double>{-10, -5, 0});
  CHECK(round_ticks(0, 48, 8).back() <= 48);
  CHECK(round_ticks(3, 3, 5) == std::vector<double>{3});
  CHECK(round_ticks(0, INFINITY, 5).size() == 1);
}

TEST_CASE("a report that cannot be written whole is not written at all") {
  const std::string path = sample::scratch_folder("report-full") + "/report.html";
  FaultyStorage full(posix_storage(), test::disk_of(1000));
  CHECK(create_report(full, path).value()->conclude(test::example_run(48)).error().code ==
        ErrorCode::NoSpace);
  CHECK(posix_storage().open(path).error().code == ErrorCode::NotFound);
  CHECK(create_report(posix_storage(), path).value()->conclude(test::example_run(48)).ok());
  CHECK(read_whole(posix_storage(), path).value() == report_html(test::example_run(48), {}));
}
