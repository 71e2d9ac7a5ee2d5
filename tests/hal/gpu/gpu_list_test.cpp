#include "hal/gpu/gpu_list.h"

#include <set>
#include <string>

#include <catch2/catch.hpp>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

GpuFacts device(const char* name, const char* missing = "") {
  GpuFacts facts;
  facts.name = name, facts.missing = missing;
  return facts;
}

}  // namespace

TEST_CASE("the first graphics device of a name that can be used is taken, whatever those before it lack") {
  const std::vector<GpuFacts> all{device("Maker 100", "its driver is old"), device("Maker 200"),
                                  device("llvmpipe")};
  CHECK(value_of(find_gpu(all, "")) == 1);
  CHECK(value_of(find_gpu(all, "maker")) == 1);
  CHECK(value_of(find_gpu(all, "LLVM")) == 2);
}

TEST_CASE("every kind of graphics device has a word of its own") {
  std::set<std::string> words;
  for (const GpuKind kind :
       {GpuKind::Discrete, GpuKind::Integrated, GpuKind::Virtual, GpuKind::Software, GpuKind::Other})
    words.insert(name(kind));
  CHECK(words == std::set<std::string>{"discrete", "integrated", "virtual", "software", "other"});
}

TEST_CASE("the name of a graphics device is not taken for a part of a longer one") {
  const std::vector<GpuFacts> all{device("Maker 660 XT"), device("Maker 660")};
  CHECK(value_of(find_gpu(all, "maker 660")) == 1);
  CHECK(value_of(find_gpu(all, "maker")) == 0);
}

TEST_CASE("what keeps a graphics device from being used is said where no other is meant") {
  const std::vector<GpuFacts> all{device("Maker 100", "its driver is old"), device("llvmpipe")};
  const auto old = find_gpu(all, "100");
  require_error(old, ErrorCode::Unsupported);
  CHECK(old.error().message == "the graphics device 'Maker 100' cannot be used: its driver is old");
  const auto any = find_gpu(std::span(all).first(1), "");
  require_error(any, ErrorCode::Unsupported);
  CHECK(any.error().message == old.error().message);

  const auto other = find_gpu(all, "200");
  require_error(other, ErrorCode::NotFound);
  CHECK(other.error().message == "there is no graphics device '200'; there are: Maker 100, llvmpipe");
  require_error(find_gpu({}, ""), ErrorCode::NotFound);
}

}  // namespace hdrcam
