// Which files are the footage, in which order, and which are none.
#include "hal/footage/footage.h"

#include <filesystem>
#include <fstream>

#include "tests/hal/footage/read_footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::difference;
using test::patches;
using test::pictures;
using test::png_file;
using test::read_footage;
using test::ReadFootage;
using test::refusal;

TEST_CASE("what lies behind the picture of a still, a preview or a gain map, is no frame") {
  const std::string folder = sample::scratch_folder("footage_second_picture");
  test::write_jpeg(folder + "/preview.jpg", patches(7, 32, 48), std::nullopt);
  test::write_jpeg(folder + "/gain.jpg", patches(8), std::nullopt);
  const std::string preview = test::text_of(folder + "/preview.jpg"),
                    gain = test::text_of(folder + "/gain.jpg");
  std::vector<std::string> files;
  for (const std::string& behind : {preview, gain, gain + preview, gain.substr(0, gain.size() / 2)}) {
    const auto number = static_cast<int>(files.size());
    const std::string& path = files.emplace_back(fmt::format("{}/{}.jpg", folder, number));
    test::write_jpeg(path, patches(number), test::Exif{1, 1000, 100, 28});
    std::ofstream(path, std::ios::binary | std::ios::app) << behind;
  }
  const ReadFootage bracket = read_footage(files);
  INFO((bracket.error ? bracket.error->message : ""));
  REQUIRE_FALSE(bracket.error);
  CHECK(bracket.losses.empty());
  CHECK(bracket.camera.framerate_hz == Approx(30));
  REQUIRE(bracket.frames.size() == files.size());
  for (std::size_t i = 0; i < files.size(); ++i)
    CHECK(difference(bracket.frames[i], bracket.camera.bits, patches(static_cast<int>(i))) < 2.5);
  // a damaged picture is not replaced by its preview
  test::write_jpeg(folder + "/large.jpg", patches(9, 480, 640), std::nullopt);
  const std::string damaged = folder + "/damaged.jpg", whole = test::text_of(folder + "/large.jpg");
  std::ofstream(damaged, std::ios::binary) << whole.substr(0, whole.size() / 2) << "\xff\xd9" << preview;
  const ReadFootage refused = read_footage({damaged});
  REQUIRE(refused.error);
  CHECK(refused.error->code == ErrorCode::Corrupt);
}

TEST_CASE("files in a folder come in the order of their numbers, in letters of either case") {
  const std::string folder = sample::scratch_folder("footage_order");
  for (const char* name : {"IMG_10.JPG", "IMG_9.jpg", "img_9.jpg", "IMG_09.jpg", "IMG_009.jpg", "img_2.png",
                           "IMG_0011.jpg", "notes.txt", "clip.mov", "._IMG_9.jpg"})
    std::ofstream(folder + "/" + name) << "x";
  const auto files = footage_in(folder);
  REQUIRE(files.ok());
  std::vector<std::string> expected;
  for (const char* name : {"clip.mov", "img_2.png", "IMG_009.jpg", "IMG_09.jpg", "IMG_9.jpg", "img_9.jpg",
                           "IMG_10.JPG", "IMG_0011.jpg"})
    expected.push_back(folder + "/" + name);
  CHECK(files.value() == expected);
  CHECK(other_pictures_in(folder).empty());
  for (const char* name : {"IMG_12.HEIC", "IMG_3.webp", "._IMG_4.heic"})
    std::ofstream(folder + "/" + name) << "x";
  CHECK(footage_in(folder).value() == expected);
  CHECK(other_pictures_in(folder) ==
        std::vector<std::string>{folder + "/IMG_3.webp", folder + "/IMG_12.HEIC"});
  const std::string empty = sample::scratch_folder("footage_empty");
  CHECK(sample::error_of(footage_in(empty)).code == ErrorCode::NotFound);
  std::ofstream(empty + "/x.bmp") << "x";  // such are read where they are named
  CHECK_THAT(sample::error_of(footage_in(empty)).message,
             Contains(empty) && Contains("name files of other kinds, such as '" + empty + "/x.bmp'"));
}

TEST_CASE("a folder whose folders hold the footage, as that of a card, leads to the first of these") {
  const std::string card = sample::scratch_folder("footage_card");
  for (const char* folder : {"/.thumbs", "/99MISC", "/100MEDIA", "/101MEDIA"})
    std::filesystem::create_directory(card + folder);
  for (const char* file : {"/.thumbs/1.jpg", "/99MISC/notes.txt", "/100MEDIA/1.jpg", "/101MEDIA/2.jpg"})
    std::ofstream(card + file) << "x";
  const Error refused = sample::error_of(footage_in(card));
  CHECK(refused.code == ErrorCode::NotFound);
  CHECK_THAT(refused.message, Contains("; such are in '" + card + "/100MEDIA'"));
}

TEST_CASE(
    "a card leads to its footage however its folders are nested, the nearest first, and a clip is one") {
  const std::string card = sample::scratch_folder("footage_whole_card");
  const auto refusal_of_card = [&card] { return sample::error_of(footage_in(card)).message; };
  std::filesystem::create_directories(card + "/private/avchd/bdmv/stream/deeper");
  std::filesystem::create_directory_symlink(card, card + "/private/round");
  std::ofstream(card + "/private/avchd/bdmv/stream/deeper/1.mts") << "x";
  CHECK_THAT(refusal_of_card(), Contains("; name files of other kinds one by one"));
  std::ofstream(card + "/private/avchd/bdmv/stream/1.mts") << "x";
  CHECK_THAT(refusal_of_card(), Contains("; such are in '" + card + "/private/avchd/bdmv/stream'"));
  std::filesystem::create_directories(card + "/walks/walk/ldr");
  std::ofstream(card + "/walks/walk/ldr/0000.png") << "x";
  std::ofstream(card + "/walks/walk/clip.json") << "x";
  CHECK_THAT(refusal_of_card(), Contains("; such are in '" + card + "/walks/walk'"));
}

TEST_CASE("neighbouring numbers are those of files whose names are alike else") {
  CHECK(is_next_number("card/IMG_0009.JPG", "card/IMG_0010.JPG"));
  CHECK(is_next_number("IMG_9.CR2", "IMG_10.CR2"));
  for (const auto& [file, next] : {std::pair("IMG_0003.JPG", "IMG_9998.JPG"),
                                   {"IMG_0010.JPG", "IMG_0009.JPG"},
                                   {"IMG_0009.JPG", "DSC_0010.JPG"},
                                   {"IMG_0009.JPG", "IMG_0010_small.JPG"},
                                   {"100/IMG_0009.JPG", "101/IMG_0010.JPG"},
                                   {"take1/x.JPG", "take2/x.JPG"},
                                   {"a.mp3", "a.mp4"},
                                   {"IMG_99999999999999999999.JPG", "IMG_100000000000000000000.JPG"}}) {
    CAPTURE(file, next);
    CHECK_FALSE(is_next_number(file, next));
  }
}

TEST_CASE("a number is earlier than another one where the names are alike else, and in one folder") {
  CHECK(is_earlier_number("card/IMG_10.JPG", "card/IMG_2.JPG"));
  CHECK(is_earlier_number("1/IMG_0010.JPG", "1/IMG_0009.JPG"));
  for (const auto& [file, next] : {std::pair("IMG_2.JPG", "IMG_10.JPG"),
                                   {"IMG_2.JPG", "IMG_2.JPG"},
                                   {"IMG_10.JPG", "DSC_2.JPG"},
                                   {"2/IMG_10.JPG", "1/IMG_2.JPG"},
                                   {"take2/x.JPG", "take1/x.JPG"}}) {
    CAPTURE(file, next);
    CHECK_FALSE(is_earlier_number(file, next));
  }
}

TEST_CASE("links in a folder are footage where their files are there, and found where they are not") {
  const std::string folder = sample::scratch_folder("footage_links"),
                    card = sample::scratch_folder("footage_links_card");
  std::ofstream(card + "/1.jpg") << "x";
  std::filesystem::create_symlink(card + "/1.jpg", folder + "/IMG_1.jpg");
  for (const char* name : {"IMG_10.jpg", "IMG_2.jpg", "IMG_3.heic", "clip.mov", "notes.txt", "._IMG_4.jpg"})
    std::filesystem::create_symlink(card + "/gone", folder + "/" + name);
  std::filesystem::create_symlink("IMG_5.png", folder + "/IMG_5.png");  // to itself
  CHECK(footage_in(folder).value() == std::vector<std::string>{folder + "/IMG_1.jpg"});
  CHECK(other_pictures_in(folder).empty());
  std::vector<std::string> broken;
  for (const char* name : {"clip.mov", "IMG_2.jpg", "IMG_3.heic", "IMG_5.png", "IMG_10.jpg"})
    broken.push_back(folder + "/" + name);
  CHECK(broken_links_in(folder) == broken);
}

TEST_CASE("what is no footage is an error that names the file") {
  const std::string folder = sample::scratch_folder("footage_wrong");
  const std::string text = folder + "/x.mp4";
  std::ofstream(text) << "this is no video, whatever it is called\n";
  const ReadFootage not_video = read_footage({text});
  CHECK_THAT(refusal(not_video, ErrorCode::NotRecording), Contains(text));
  CHECK(read_footage({folder + "/missing.mp4"}).error->code == ErrorCode::NotFound);
  for (const char* name : {"/empty.jpg", "/empty.mp4", "/empty.dng"}) {
    std::ofstream(folder + name).flush();
    const ReadFootage empty = read_footage({folder + name});
    CHECK_THAT(refusal(empty, ErrorCode::NotRecording), Contains(fmt::format("{}' is empty", name)));
  }

  const ReadFootage sizes = read_footage(
      {png_file(folder + "/a.png", patches(0)), png_file(folder + "/b.png", patches(0, 32, 96))});
  CHECK_THAT(refusal(sizes, ErrorCode::SizeChanged),
             Contains("b.png") && Contains("96x32") && Contains("of one kind and size"));
}

TEST_CASE("pictures that no recording can hold are refused at once, and named") {
  const std::string folder = sample::scratch_folder("footage_sides");
  for (const auto& [rows, cols] : {std::pair{1, 64}, std::pair{64, 1}, std::pair{2, 16385}}) {
    const std::string path =
        png_file(fmt::format("{}/{}x{}.png", folder, cols, rows), patches(0, rows, cols));
    const ReadFootage refused = read_footage({path});
    CHECK_THAT(refusal(refused, ErrorCode::Unsupported),
               Contains(path) && Contains(fmt::format("has {}x{} pixels", cols, rows)));
  }
  CHECK_FALSE(read_footage({png_file(folder + "/wide.png", patches(0, 2, 16384))}).error);
}

TEST_CASE("a name is no pattern, and a playlist opens nothing") {
  const std::string folder = sample::scratch_folder("footage_names");
  test::write_jpeg(folder + "/a%02d.jpg", patches(0), std::nullopt);
  test::write_jpeg(folder + "/a01.jpg", patches(1), std::nullopt);
  const ReadFootage named = read_footage({folder + "/a%02d.jpg"});
  REQUIRE_FALSE(named.error);
  REQUIRE(named.frames.size() == 1);
  CHECK(difference(named.frames[0], named.camera.bits, patches(0)) < 2.5);

  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(3)).ok());
  for (const char* list : {"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nx.mkv\n#EXT-X-ENDLIST\n",
                           "ffconcat version 1.0\nfile x.mkv\n"}) {
    std::ofstream(folder + "/list.txt") << list;
    const ReadFootage playlist = read_footage({folder + "/list.txt"});
    REQUIRE(playlist.error);
    CHECK(playlist.error->code == ErrorCode::NotRecording);
  }
}

TEST_CASE("a video whose file states no frame rate is no still") {
  const std::string folder = sample::scratch_folder("footage_no_rate");
  REQUIRE(test::write_video(folder + "/x.mkv", VideoCodec::H264, pictures(2)).ok());
  REQUIRE(test::remux(folder + "/x.mkv", folder + "/x.nut", "nut").ok());  // from two frames none is found
  auto footage = open_footage(posix_storage(), {folder + "/x.nut"}, 0);
  REQUIRE(footage.ok());
  CHECK_FALSE(footage.value()->still());
  CHECK(footage.value()->timed());
  png_file(folder + "/x.png", patches(0));
  footage = open_footage(posix_storage(), {folder + "/x.png"}, 0);
  REQUIRE(footage.ok());
  CHECK(footage.value()->still());
}
