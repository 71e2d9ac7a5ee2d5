// Root opens everything: for as long as this lives, it is nobody, in the whole process; any other user stays
// who it is. Include last: it brings Catch2.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <catch2/catch.hpp>

namespace hdrcam::test {

class AsNobody {
 public:
  AsNobody() { REQUIRE((user_ != 0 || ::seteuid(kNobody) == 0)); }
  ~AsNobody() { (void)!::seteuid(user_); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;
  uid_t user_ = ::geteuid();
};

}  // namespace hdrcam::test
