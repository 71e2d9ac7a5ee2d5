#include "hal/core/cpu.h"

#include <cstdlib>
#include <string>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("kernels are those of the instruction set that HDRCAM_ISA asks for", "[isa]") {
  const char* asked = std::getenv("HDRCAM_ISA");
  const std::string found = name(instruction_set());
  INFO("HDRCAM_ISA " << (asked == nullptr ? "not set" : asked) << ", kernels " << found);
  if (asked == nullptr)
    CHECK((found == "baseline" || found == "avx2" || found == "avx512"));
  else
    CHECK(found == asked);  // ./run test asks only for what the machine has
  const char *baseline = "baseline", *avx2 = "avx2", *avx512 = "avx512";
  CHECK(pick_kernels(baseline, avx2, avx512) == found);
}
