// What the program under test prints, in this process or in one that a test started, stays out of the test
// run: both standard streams are kept aside during a test, and shown where it fails or warns.
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "tests/allocations.h"

#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>

namespace {

// One standard stream, whose descriptor leads to a file without a name while it is kept aside.
class QuietStream {
 public:
  explicit QuietStream(std::FILE* stream) : stream_(stream) {}

  void keep_aside() {
    std::fflush(stream_);
    aside_ = std::tmpfile();
    if (aside_ == nullptr) return;
    shown_ = dup(fileno(stream_));
    dup2(fileno(aside_), fileno(stream_));
  }
  void give_back(bool show) {
    if (aside_ == nullptr) return;
    std::fflush(stream_);
    dup2(shown_, fileno(stream_));
    close(shown_);
    std::rewind(aside_);
    char part[4096];
    while (show) {
      const std::size_t size = std::fread(part, 1, sizeof part, aside_);
      if (size == 0) break;
      std::fwrite(part, 1, size, stream_);
    }
    std::fclose(aside_);
    aside_ = nullptr;
  }

 private:
  std::FILE* const stream_;
  std::FILE* aside_ = nullptr;
  int shown_ = -1;
};

class QuietStreams : public Catch::TestEventListenerBase {
 public:
  using Catch::TestEventListenerBase::TestEventListenerBase;

  void testCaseStarting(const Catch::TestCaseInfo&) override {
    warned_ = false;
    // a sanitizer reports on these streams and ends the process: nobody would show its report
    if (!hdrcam::allocations_are_counted()) return;
    std::cout.flush();
    out_.keep_aside(), err_.keep_aside();
  }
#if CATCH_VERSION_MAJOR >= 3
  void assertionEnded(const Catch::AssertionStats& stats) override { look_for_warning(stats); }
#else
  bool assertionEnded(const Catch::AssertionStats& stats) override { return look_for_warning(stats), false; }
#endif
  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    const bool show = warned_ || stats.totals.assertions.failed > 0;
    std::cout.flush();
    out_.give_back(show), err_.give_back(show);
  }

 private:
  void look_for_warning(const Catch::AssertionStats& stats) {
    warned_ |= stats.assertionResult.getResultType() == Catch::ResultWas::Warning;
  }

  QuietStream out_{stdout}, err_{stderr};
  bool warned_ = false;
};

}  // namespace

CATCH_REGISTER_LISTENER(QuietStreams)
