#include "firmware_host/bench/kernel_rates.h"

#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <map>
#include <nlohmann/json.hpp>

#include "firmware_host/bench/ceiling_kernels.h"
#include "firmware_host/version.h"
#include "hal/core/cpu.h"
#include "hal/core/image.h"
#include "hal/core/json_text.h"
#include "hal/core/stopwatch.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {
namespace {

constexpr int kRepetitions = 5;

// How long each kernel runs, and what ends all of them; then their rates mean nothing.
struct Patience {
  double seconds;
  const std::atomic<bool>& stop;
};

// Runs per second, of the fastest repetition.
double runs_per_s(const Patience& patience, const std::function<void()>& run) {
  const double ms = 1000 * patience.seconds / kRepetitions;
  double best = 0;
  run();  // caches and page tables
  for (int i = 0; i < kRepetitions && !patience.stop; ++i) {
    Stopwatch watch;
    double spent = 0;
    int runs = 0;
    do {
      run(), ++runs;
      spent += watch.lap_ms();
    } while (spent < ms && !patience.stop);
    best = std::max(best, 1000 * runs / spent);
  }
  return best;
}

// What keeps results alive.
void use(float value) { asm volatile("" : : "g"(value)); }

double flops_per_s(const Patience& patience) {
  constexpr int kRounds = 20'000;
  const CeilingKernels& kernels = ceiling_kernels();
  return runs_per_s(patience, [&] { use(kernels.multiply_add(kRounds)); }) * kRounds *
         kernels.flops_per_round;
}

double look_ups_per_s(const Patience& patience) {
  constexpr int kEntries = 1 << 15, kPlaces = 1 << 16;
  Pcg32 random(1);
  Image<float> table(1, 1, 2 * kEntries);
  Image<int> places(1, 1, kPlaces);
  for (int& place : places.samples()) place = random.below(kEntries);
  return kPlaces * runs_per_s(patience, [&] {
           use(ceiling_kernels().look_up(table.plane(0), places.plane(0), kPlaces));
         });
}

// Bytes per second of streams that touch so many bytes in all.
double bytes_per_s(double footprint, const Patience& patience) {
  constexpr int kBytes = 3 * sizeof(float);     // for each element: two streams are read, one is written
  constexpr int kLeast = 1024, kMultiple = 16;  // elements
  const int n = std::max(kLeast, static_cast<int>(footprint / kBytes)) / kMultiple * kMultiple;
  Image<float> planes(3, 1, n);
  return 1.0 * kBytes * n * runs_per_s(patience, [&] {
           ceiling_kernels().stream(planes.plane(0), planes.plane(1), planes.plane(2), n);
         });
}

KernelRates measured_here(std::span<const KernelTask> tasks, const Patience& patience) {
  flush_denormals();
  KernelRates rates{flops_per_s(patience), look_ups_per_s(patience), {}};
  std::map<double, double> streams;  // bytes per second, by footprint
  for (const KernelTask& task : tasks) {
    if (patience.stop) break;
    KernelRate rate{task.name, task.item, task.items * runs_per_s(patience, task.run), 0,
                    KernelBound::Unknown};
    const auto bounded = [&](KernelBound bound, double available, double needed) {
      if (needed <= 0 || (rate.ceiling_per_s > 0 && available / needed >= rate.ceiling_per_s)) return;
      rate.ceiling_per_s = available / needed, rate.bound = bound;
    };
    bounded(KernelBound::Arithmetic, rates.flops_per_s, task.flops);
    bounded(KernelBound::LookUps, rates.look_ups_per_s, task.look_ups);
    if (task.bytes > 0) {
      const auto [stream, is_new] = streams.try_emplace(task.footprint, 0);
      if (is_new) stream->second = bytes_per_s(task.footprint, patience);
      bounded(KernelBound::Memory, stream->second, task.bytes);
    }
    rates.kernels.push_back(rate);
  }
  return rates;
}

}  // namespace

const char* name(KernelBound bound) {
  switch (bound) {
    case KernelBound::Arithmetic:
      return "arithmetic";
    case KernelBound::Memory:
      return "memory";
    case KernelBound::LookUps:
      return "look-ups";
    case KernelBound::Unknown:
      break;
  }
  return "";
}

Result<KernelRates> measure_kernels(std::span<const KernelTask> tasks, double seconds,
                                    const std::atomic<bool>& stop) {
  // on a thread of its own: the caller keeps its denormals
  KernelRates rates = std::async(std::launch::async, [&] {
                        return measured_here(tasks, {seconds, stop});
                      }).get();
  if (stop) return Error{ErrorCode::Interrupted, "stopped before all kernels were measured"};
  return rates;
}

std::string rates_table(const KernelRates& rates) {
  std::string table = fmt::format(
      "{}, {}; one thread: {:.1f} GFLOP/s of multiply-adds, {:.2f} G look-ups/s.\n\n"
      "| kernel | rate, per second | ceiling | share of it | bound by |\n|---|---|---|---|---|\n",
      cpu_model(), name(instruction_set()), rates.flops_per_s / 1e9, rates.look_ups_per_s / 1e9);
  const auto amount = [](double value, const std::string& item) {
    return value >= 1e9 ? fmt::format("{:.2f} G {}", value / 1e9, item)
                        : fmt::format("{:.1f} M {}", value / 1e6, item);
  };
  for (const KernelRate& rate : rates.kernels)
    table += rate.ceiling_per_s > 0
                 ? fmt::format("| {} | {} | {} | {:.0f} % | {} |\n", rate.kernel,
                               amount(rate.items_per_s, rate.item), amount(rate.ceiling_per_s, rate.item),
                               100 * rate.items_per_s / rate.ceiling_per_s, name(rate.bound))
                 : fmt::format("| {} | {} | | | |\n", rate.kernel, amount(rate.items_per_s, rate.item));
  return table;
}

std::string rates_json(const KernelRates& rates, int rows, int cols) {
  using Json = nlohmann::ordered_json;
  Json kernels = Json::array();
  for (const KernelRate& rate : rates.kernels) {
    Json object{{"kernel", rate.kernel}, {"item", rate.item}, {"per_s", rate.items_per_s}};
    if (rate.ceiling_per_s > 0)
      object["ceiling_per_s"] = rate.ceiling_per_s, object["bound"] = name(rate.bound);
    kernels.push_back(object);
  }
  const Json json{{"hdrcam", kVersion},
                  {"cpu", cpu_model()},
                  {"instruction_set", name(instruction_set())},
                  {"width", cols},
                  {"height", rows},
                  {"flops_per_s", rates.flops_per_s},
                  {"look_ups_per_s", rates.look_ups_per_s},
                  {"kernels", kernels}};
  return json_text(json, 1) + "\n";
}

}  // namespace hdrcam
