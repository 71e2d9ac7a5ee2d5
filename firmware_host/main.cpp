// The process: signals, the real disk, the real standard streams, the log. Everything else is program.cpp.
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <csignal>

#include <atomic>
#include <cstddef>
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

// The first ^C (or SIGTERM) requests a clean end and lets system calls continue; SA_RESETHAND restores the
// default action, so the second one ends the process.
void stop_cleanly_once(int signal) {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(signal, &action, nullptr);
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
  stop_cleanly_once(SIGINT);
  stop_cleanly_once(SIGTERM);
  stop_cleanly_on_hangup();
  const std::span<const char* const> args(argv + 1, static_cast<std::size_t>(argc > 0 ? argc - 1 : 0));
  return hdrcam::run_program(args, hdrcam::posix_storage(), stop_requested, std::cout, std::cerr);
}
