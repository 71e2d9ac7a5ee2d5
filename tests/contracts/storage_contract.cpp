#include "tests/contracts/storage_contract.h"

#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

void write(const StorageUnderTest& facts, const std::string& path, std::string_view text) {
  auto file = value_of(facts.storage.create(path));
  require_done(file->write_at(0, bytes_of(text)));
  require_done(file->sync());
}

void reads_back_what_was_written(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/written";
  write(facts, path, "hello world");
  {
    auto file = value_of(facts.storage.create(path));  // what was there is gone
    CHECK(value_of(file->size()) == 0);
    require_done(file->write_at(6, bytes_of("again")));
    require_done(file->write_at(0, bytes_of("light,")));
  }
  CHECK(value_of(read_whole(facts.storage, path)) == "light,again");
}

void reads_short_at_the_end(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/short";
  write(facts, path, "12345");
  auto file = value_of(facts.storage.open(path));
  std::array<std::byte, 8> bytes{};
  CHECK(value_of(file->size()) == 5);
  CHECK(value_of(file->read_at(3, bytes)) == 2);
  CHECK(bytes[0] == std::byte{'4'});
  CHECK(value_of(file->read_at(5, bytes)) == 0);
  CHECK(value_of(file->read_at(500, bytes)) == 0);
}

void names_what_is_missing(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/missing";
  const auto opened = facts.storage.open(path);
  REQUIRE_FALSE(opened.ok());
  CHECK(opened.error().code == ErrorCode::NotFound);
  CHECK(opened.error().message.find(path) != std::string::npos);
  CHECK_FALSE(facts.storage.remove(path).ok());
  CHECK_FALSE(facts.storage.rename(path, path + "2").ok());
  CHECK_FALSE(facts.storage.create(facts.folder + "/no/such/folder/file").ok());
}

void replaces_by_rename(const StorageUnderTest& facts) {
  const std::string from = facts.folder + "/from", to = facts.folder + "/to";
  write(facts, to, "old");
  write(facts, from, "new");
  require_done(facts.storage.rename(from, to));
  CHECK(value_of(read_whole(facts.storage, to)) == "new");
  CHECK_FALSE(facts.storage.open(from).ok());
  require_done(facts.storage.remove(to));
  CHECK_FALSE(facts.storage.open(to).ok());
}

void renames_to_a_new_name_only_where_none_is(const StorageUnderTest& facts) {
  const std::string from = facts.folder + "/made", to = facts.folder + "/taken";
  write(facts, to, "first");
  write(facts, from, "second");
  const Result<void> late = facts.storage.rename(from, to, Creation::New);
  REQUIRE_FALSE(late.ok());
  CHECK(late.error().code == ErrorCode::Exists);
  CHECK(value_of(read_whole(facts.storage, to)) == "first");
  CHECK(value_of(read_whole(facts.storage, from)) == "second");
  require_done(facts.storage.remove(to));
  require_done(facts.storage.rename(from, to, Creation::New));
  CHECK(value_of(read_whole(facts.storage, to)) == "second");
}

void makes_folders(const StorageUnderTest& facts) {
  const std::string folder = facts.folder + "/a/b/c";
  require_done(facts.storage.make_directories(folder));
  require_done(facts.storage.make_directories(folder));
  write(facts, folder + "/file", "deep");
  CHECK(value_of(read_whole(facts.storage, folder + "/file")) == "deep");
}

void makes_a_new_file_only_where_none_is(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/new";
  require_done(value_of(facts.storage.create(path, Creation::New))->write_at(0, bytes_of("first")));
  const auto again = facts.storage.create(path, Creation::New);
  REQUIRE_FALSE(again.ok());
  CHECK(again.error().code == ErrorCode::Exists);
  CHECK(again.error().message.find(path) != std::string::npos);
  CHECK(value_of(read_whole(facts.storage, path)) == "first");
}

void knows_a_file_by_any_name(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/known", missing = facts.folder + "/unknown";
  require_done(facts.storage.make_directories(facts.folder + "/sub"));
  write(facts, path, "12345");
  const FileFacts one = value_of(facts.storage.look_at(path));
  const FileFacts other = value_of(facts.storage.look_at(facts.folder + "/sub/../known"));
  CHECK(one.kind == FileKind::Regular);
  CHECK(one.size_bytes == 5);
  CHECK(one.inode == other.inode);
  CHECK(one.device == other.device);
  CHECK(one.real_path == other.real_path);
  CHECK(value_of(facts.storage.look_at(facts.folder)).kind == FileKind::Folder);
  CHECK(value_of(facts.storage.look_at(missing)).kind == FileKind::Missing);
  CHECK(value_of(facts.storage.look_at(facts.folder + "/no/such/file")).kind == FileKind::Missing);
}

void names_a_file_once_it_is_whole(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/whole";
  write(facts, path, "old");
  std::string part;
  {
    FileInMaking given_up = value_of(FileInMaking::beside(facts.storage, path));
    part = given_up.path();
    write(facts, part, "half");
  }
  CHECK(value_of(facts.storage.look_at(part)).kind == FileKind::Missing);
  CHECK(value_of(read_whole(facts.storage, path)) == "old");
  FileInMaking making = value_of(FileInMaking::beside(facts.storage, path));
  CHECK(making.path() != part);  // nobody can prepare it
  write(facts, making.path(), "new");
  require_done(making.commit());
  CHECK(value_of(read_whole(facts.storage, path)) == "new");
  require_done(write_whole(facts.storage, path, bytes_of("newer")));
  CHECK(value_of(read_whole(facts.storage, path)) == "newer");
  CHECK_FALSE(write_whole(facts.storage, facts.folder, bytes_of("into a folder")).ok());
}

void keeps_what_another_program_wrote_meanwhile(const StorageUnderTest& facts) {
  for (const bool replaces : {false, true}) {
    const std::string path = fmt::format("{}/meanwhile{}", facts.folder, replaces);
    if (replaces) write(facts, path, "earlier");
    FileInMaking one = value_of(FileInMaking::beside(facts.storage, path));
    FileInMaking two = value_of(FileInMaking::beside(facts.storage, path));
    write(facts, one.path(), "one");
    write(facts, two.path(), "two");
    require_done(one.commit());
    const Result<void> late = two.commit();
    REQUIRE_FALSE(late.ok());
    CHECK(late.error().code == ErrorCode::Exists);
    CHECK(late.error().message.find(two.path()) != std::string::npos);
    CHECK(value_of(read_whole(facts.storage, path)) == "one");
    CHECK(value_of(read_whole(facts.storage, two.path())) == "two");
  }
}

void removes_what_came_late_with_nothing_in_it(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/begun";
  std::string part;
  {
    FileInMaking late = value_of(FileInMaking::beside(facts.storage, path));
    part = late.path();
    write(facts, part, "");
    write(facts, path, "first");
    const Result<void> refused = late.commit(Durability::WrittenBack, Forestalled::Goes);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Exists);
    CHECK(refused.error().message.find(part) == std::string::npos);
  }
  CHECK(value_of(facts.storage.look_at(part)).kind == FileKind::Missing);
  CHECK(value_of(read_whole(facts.storage, path)) == "first");
}

void leaves_a_file_that_is_held(const StorageUnderTest& facts) {
  const std::string path = facts.folder + "/held";
  auto writing = value_of(facts.storage.create(path));
  require_done(writing->hold());
  CHECK(value_of(facts.storage.open(path))->hold().error().code == ErrorCode::Busy);
  const auto replace = [&] { return write_whole(facts.storage, path, bytes_of("new")); };
  const Result<void> refused = replace();
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Busy);
  CHECK(refused.error().message.find("name another file") != std::string::npos);
  require_done(writing->write_at(0, bytes_of("whole")));
  CHECK(value_of(read_whole(facts.storage, path)) == "whole");
  writing.reset();
  require_done(replace());
  CHECK(value_of(read_whole(facts.storage, path)) == "new");
}

struct Clause {
  const char* sentence;
  void (*holds)(const StorageUnderTest&);
};
constexpr Clause kClauses[] = {
    {"reads back what was written", reads_back_what_was_written},
    {"reads short at the end of a file", reads_short_at_the_end},
    {"names the file that is missing", names_what_is_missing},
    {"replaces a file by rename", replaces_by_rename},
    {"renames to a new name only where none is", renames_to_a_new_name_only_where_none_is},
    {"makes folders and their parents", makes_folders},
    {"makes a new file only where none is", makes_a_new_file_only_where_none_is},
    {"knows a file by any of its names", knows_a_file_by_any_name},
    {"gives a file its name once it is whole", names_a_file_once_it_is_whole},
    {"keeps what another program wrote meanwhile", keeps_what_another_program_wrote_meanwhile},
    {"removes what came late with nothing in it", removes_what_came_late_with_nothing_in_it},
    {"leaves a file that is held", leaves_a_file_that_is_held},
};

}  // namespace

void keeps_storage_contract(const StorageUnderTest& storage) {
  for (const Clause& clause : kClauses) DYNAMIC_SECTION(storage.name << " " << clause.sentence) {
      clause.holds(storage);
    }
}

}  // namespace hdrcam
