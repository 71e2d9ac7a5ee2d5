// Reads a trace file as a viewer does: spans by thread, and those that cross each other, which no viewer can
// draw.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace hdrcam::test {

struct ReadSpan {
  std::string name;
  double begin_us = 0, end_us = 0;
};

class ReadTrace {
 public:
  explicit ReadTrace(const std::string& text) {
    const auto json = nlohmann::json::parse(text);
    for (const auto& event : json["traceEvents"]) {
      if (event["ph"] == "M") {
        if (event["name"] == "thread_name") names_[event["tid"]] = event["args"]["name"];
        continue;
      }
      if (event["ph"] != "X") throw std::runtime_error("an event that is no span");
      const double begin = event["ts"], length = event["dur"];
      if (length < 0) throw std::runtime_error("a span that ends before it begins");
      spans_[event["tid"]].push_back({event["name"], begin, begin + length});
    }
  }

  // Of all threads with spans; "" for one without a name.
  std::set<std::string> threads() const {
    std::set<std::string> all;
    for (const auto& [id, spans] : spans_) all.insert(names_.contains(id) ? names_.at(id) : "");
    return all;
  }
  std::set<std::string> names_on(const std::string& thread) const {
    std::set<std::string> all;
    for (const auto& [id, spans] : spans_)
      if (names_.at(id) == thread)
        for (const ReadSpan& span : spans) all.insert(span.name);
    return all;
  }
  // The first of that name.
  const ReadSpan& span(const std::string& name) const {
    for (const auto& [id, spans] : spans_)
      for (const ReadSpan& span : spans)
        if (span.name == name) return span;
    throw std::runtime_error("no span " + name);
  }
  // One sentence per span that begins in another of its thread and ends after it. Times are of whole
  // nanoseconds.
  std::vector<std::string> crossings() const {
    constexpr double kRounding_us = 0.002;
    std::vector<std::string> found;
    for (const auto& [id, spans] : spans_) {
      std::vector<const ReadSpan*> open;
      for (const ReadSpan& span : spans) {  // sorted by their begin, the outer ones first
        while (!open.empty() && open.back()->end_us <= span.begin_us + kRounding_us) open.pop_back();
        if (!open.empty() && span.end_us > open.back()->end_us + kRounding_us)
          found.push_back(span.name + " crosses the end of " + open.back()->name);
        open.push_back(&span);
      }
    }
    return found;
  }

 private:
  std::map<int, std::string> names_;
  std::map<int, std::vector<ReadSpan>> spans_;
};

}  // namespace hdrcam::test
