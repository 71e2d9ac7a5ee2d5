// Parts of a run's record as JSON, the same in stats.json and in the live view. Reentrant.
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/sinks/run_record.h"

namespace hdrcam {

// NamedValues by their name, in their order.
template <class Values>
nlohmann::ordered_json object_of(const Values& values) {
  auto object = nlohmann::ordered_json::object();
  for (const NamedValue& entry : values) object[std::string(entry.name)] = entry.value;
  return object;
}

// The same of counters, whose counts are whole numbers: 31, not 31.0, which readers of a strict type refuse.
inline nlohmann::ordered_json counters_of(const std::vector<NamedValue>& counters) {
  constexpr double kExact = 1LL << 53;  // what a double counts one by one
  nlohmann::ordered_json object = object_of(counters);
  for (const NamedValue& counter : counters)
    if (std::abs(counter.value) < kExact && counter.value == std::trunc(counter.value))
      object[std::string(counter.name)] = static_cast<std::int64_t>(counter.value);
  return object;
}

// shares: by enum Provenance
template <class Shares>
nlohmann::ordered_json provenance_of(const Shares& shares) {
  auto object = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < kProvenances; ++i) object[kProvenanceLooks[i].key] = shares[i];
  return object;
}

}  // namespace hdrcam
