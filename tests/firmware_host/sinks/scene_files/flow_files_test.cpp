#include "firmware_host/sinks/scene_files/flow_files.h"

#include <cstring>

#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/scene_file_readers.h"

using namespace hdrcam;

TEST_CASE("a .flo file is the tag, the size and the interleaved vectors, row by row, to the byte") {
  Image<float> flow(2, 1, 2);
  flow.at(0, 0, 0) = 1, flow.at(1, 0, 0) = -2, flow.at(0, 0, 1) = 0.5f, flow.at(1, 0, 1) = 0;
  const std::vector<std::byte> bytes = encode_flo(flow, 1, 2);
  const unsigned char expected[] = {'P',  'I',  'E', 'H', 2, 0,    0, 0, 1, 0,    0, 0, 0, 0,
                                    0x80, 0x3f, 0,   0,   0, 0xc0, 0, 0, 0, 0x3f, 0, 0, 0, 0};
  REQUIRE(bytes.size() == sizeof expected);
  CHECK(std::memcmp(bytes.data(), expected, sizeof expected) == 0);
}

TEST_CASE("a frame without that neighbour has a file in which all motion is unknown") {
  const std::string folder = sample::scratch_folder("flow_files");
  auto sink =
      create_flow_files(posix_storage(), "--flow-backward", folder + "/new/%04d.flo", &HdrFrame::flow);
  REQUIRE(sink.ok());
  REQUIRE(test::emit(*sink.value(), test::example_frame(3)).ok());
  REQUIRE(test::emit(*sink.value(), test::example_frame(4, test::With::DepthAndFlow)).ok());
  const auto first = test::read_flow(folder + "/new/0003.flo"),
             second = test::read_flow(folder + "/new/0004.flo");
  CHECK((first.width == 32 && first.height == 24));
  CHECK_FALSE(first.known(0, 0));
  CHECK_FALSE(first.known(23, 31));
  CHECK((second.u(5, 6) == 0.5f && second.v(5, 6) == -1.5f));
}
