// Errors as values. Every call that can fail for a reason outside the program returns Result<T>: a value or
// an Error with one sentence that names the thing, the value and what to do. Exceptions of a library are
// caught in the one file that wraps it. Reentrant.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "hal/core/check.h"

namespace hdrcam {

enum class ErrorCode {
  Invalid,       // an argument, option or setting that is not possible
  NotFound,      // the named thing does not exist
  NotRecording,  // the file exists but is not one of our recordings
  Truncated,     // a recording that ends in the middle; what precedes the cut is valid
  Corrupt,       // a checksum or structure that is wrong
  BadExposure,   // an exposure that is missing, zero, negative or not finite
  SizeChanged,   // frames of different size within one clip
  TooShort,      // fewer frames than the method needs
  Permission,    // exists, but may not be read or written
  Exists,        // an output that exists already
  NoSpace,       // the disk or quota is full
  Io,            // any other failure of the operating system
  Busy,          // held by another program
  Unplugged,     // the device is gone
  Timeout,       // nothing arrived within the time limit
  Unsupported,   // valid, but not offered by this build or device
  Interrupted,   // the user asked to stop
};

struct Error {
  ErrorCode code = ErrorCode::Io;
  std::string message;  // one sentence without a full stop
  int sys_errno = 0;    // 0 where the operating system was not involved
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT: a value is a result
  Result(Error error) : content_(std::move(error)) {}  // NOLINT: so is an error

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  T& value() & { return HDRCAM_CHECK_OK(*this), std::get<T>(content_); }
  const T& value() const& { return HDRCAM_CHECK_OK(*this), std::get<T>(content_); }
  T&& value() && { return HDRCAM_CHECK_OK(*this), std::get<T>(std::move(content_)); }
  T* operator->() { return &value(); }
  T& operator*() & { return value(); }

  const Error& error() const { return std::get<Error>(content_); }

 private:
  std::variant<T, Error> content_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)), ok_(false) {}  // NOLINT: an error is a result

  bool ok() const { return ok_; }
  explicit operator bool() const { return ok_; }
  void value() const { HDRCAM_CHECK_OK(*this); }
  const Error& error() const { return error_; }

 private:
  Error error_;
  bool ok_ = true;
};

}  // namespace hdrcam

// TRY(expression): the value of a Result, or returns its Error from the function. Not within the braces of an
// aggregate behind a member that owns something, nor within new T(..): what is made before is never freed.
#define TRY(expression)                                                 \
  ({                                                                    \
    auto try_result_ = (expression);                                    \
    if (!try_result_.ok()) return ::hdrcam::Error(try_result_.error()); \
    std::move(try_result_).value();                                     \
  })
