// The process: signals, the real disk, the real standard streams, the log. Everything else is program.cpp.
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <ctime>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>

#include "firmware_host/program.h"
#include "firmware_host/terminal.h"
#include "hal/core/freed_pictures.h"
#include "hal/storage.h"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

// The first ^C (or SIGTERM) requests a clean end and lets system calls continue; a later one ends the
// process. What comes within kOneRequest_ns of the first is the same request: 'timeout' sends its signal to
// the program and then to the program's group, and other wrappers pass on what the terminal has sent already.
constexpr std::int64_t kOneRequest_ns = 300'000'000;

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

template <int kSignal>
void request_stop(int) {
  static constinit std::atomic<std::int64_t> first_ns{0};  // of this signal; 0: none yet
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
  const std::int64_t now_ns = monotonic_ns();
  std::int64_t earlier_ns = 0;
  stop_requested = true;
  if (first_ns.compare_exchange_strong(earlier_ns, now_ns) || now_ns - earlier_ns < kOneRequest_ns) return;
  std::signal(kSignal, SIG_DFL);
  std::raise(kSignal);
}

template <int kSignal>
void stop_cleanly_at_first() {
  struct sigaction action {};
  action.sa_handler = request_stop<kSignal>;
  action.sa_flags = SA_RESTART;
  sigaction(kSignal, &action, nullptr);
}

// A lost terminal ends a run as ^C does. It may hang up more than once; nohup's setting is kept.
void stop_cleanly_on_hangup() {
  struct sigaction action {};
  sigaction(SIGHUP, nullptr, &action);
  if (action.sa_handler == SIG_IGN) return;
  action = {};
  action.sa_handler = [](int) { stop_requested = true; };
  action.sa_flags = SA_RESTART;
  sigaction(SIGHUP, &action, nullptr);
}

// Log messages of the code below are remarks.
class RemarkSink : public spdlog::sinks::base_sink<std::mutex> {
  void sink_it_(const spdlog::details::log_msg& message) override {
    hdrcam::remark("note: {}\n", std::string_view(message.payload.data(), message.payload.size()));
  }
  void flush_() override {}
};

// They go where progress goes; the standard output is for results.
void log_to_standard_error() {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("hdrcam", std::make_shared<RemarkSink>()));
}

}  // namespace

int main(int argc, char** argv) {
  hdrcam::give_back_freed_pictures();
  hdrcam::occupy_standard_streams();
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is a write error, not the end of a recording
  std::signal(SIGXFSZ, SIG_IGN);  // and so is a file that reaches the limit of ulimit -f
  log_to_standard_error();
  stop_cleanly_at_first<SIGINT>();
  stop_cleanly_at_first<SIGTERM>();
  stop_cleanly_on_hangup();
  const std::span<const char* const> args(argv + 1, static_cast<std::size_t>(argc > 0 ? argc - 1 : 0));
  const auto storage = hdrcam::stoppable_posix_storage(stop_requested);
  return hdrcam::run_program(args, *storage, stop_requested, std::cout, std::cerr);
}
