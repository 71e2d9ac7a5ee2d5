// What only a real file system has: links, FIFOs, devices, permissions.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "hal/descriptor.h"
#include "hal/standard_output.h"
#include "hal/storage.h"
#include "tests/support/becomes_true.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/files.h"

namespace {

thread_local bool sets_no_permissions = false;  // as a file system does whose files are all somebody else's
thread_local std::vector<std::string>* synced = nullptr;  // where the files go that are synced

}  // namespace

// They take the place of the C library's.
extern "C" int chmod(const char* path, mode_t mode) noexcept {
  if (!sets_no_permissions) return ::fchmodat(AT_FDCWD, path, mode, 0);
  errno = EPERM;
  return -1;
}

extern "C" int fdatasync(int fd) {
  if (synced != nullptr)
    synced->push_back(std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", fd)).string());
  return static_cast<int>(::syscall(SYS_fdatasync, fd));
}

namespace hdrcam {
namespace {

namespace fs = std::filesystem;

struct ScratchFolder {
  std::string operator/(const char* file) const { return name + "/" + file; }
  std::string name = test::scratch_folder("posix_storage");
};

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST_CASE("a file written through a symbolic link leaves the link where it is") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "target", bytes_of("old")));
  fs::create_symlink("target", folder / "link");
  fs::create_symlink("not-there-yet", folder / "dangling");
  require_done(write_whole(posix_storage(), folder / "link", bytes_of("new")));
  require_done(write_whole(posix_storage(), folder / "dangling", bytes_of("made")));
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(fs::is_symlink(folder / "dangling"));
  CHECK(test::text_of(folder / "target") == "new");
  CHECK(test::text_of(folder / "not-there-yet") == "made");
}

TEST_CASE("a new file is never made through a symbolic link that somebody prepared") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "victim", bytes_of("precious")));
  fs::create_symlink("victim", folder / "trap");
  CHECK(posix_storage().create(folder / "trap", Creation::New).error().code == ErrorCode::Exists);
  CHECK(test::text_of(folder / "victim") == "precious");
}

TEST_CASE("a file that may not grow any more is told from a full disk") {
  const ScratchFolder folder;
  const auto file = value_of(posix_storage().create(folder / "large", Creation::New));
  rlimit usual{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &usual) == 0);
  rlimit small = usual;
  small.rlim_cur = 4096;
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  const Result<void> beyond = file->write_at(4096, bytes_of("x"));
  const bool restored = setrlimit(RLIMIT_FSIZE, &usual) == 0;
  std::signal(SIGXFSZ, before);
  REQUIRE(restored);
  require_error(beyond, ErrorCode::NoSpace);
  CHECK(beyond.error().sys_errno == EFBIG);
  CHECK(beyond.error().message.find("as large as a file can be here (FAT: 4 GB, or 'ulimit -f')") !=
        std::string::npos);
  CHECK(beyond.error().message.find("free some") == std::string::npos);
}

TEST_CASE("a file that is replaced keeps its permissions") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "secret", bytes_of("old")));
  REQUIRE(chmod((folder / "secret").c_str(), 0600) == 0);
  require_done(write_whole(posix_storage(), folder / "secret", bytes_of("new")));
  struct stat status {};
  REQUIRE(stat((folder / "secret").c_str(), &status) == 0);
  CHECK((status.st_mode & 07777) == 0600);
}

TEST_CASE("a file is replaced where nobody may set permissions, if they are the same already") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "one", bytes_of("old")));
  require_done(write_whole(posix_storage(), folder / "secret", bytes_of("old")));
  REQUIRE(chmod((folder / "secret").c_str(), 0600) == 0);
  sets_no_permissions = true;
  const auto same = write_whole(posix_storage(), folder / "one", bytes_of("new"));
  const auto other = write_whole(posix_storage(), folder / "secret", bytes_of("new"));
  sets_no_permissions = false;
  require_done(same);
  CHECK(test::text_of(folder / "one") == "new");
  require_error(other, ErrorCode::Permission);
  CHECK(test::text_of(folder / "secret") == "old");
}

TEST_CASE("a file where a folder is needed is named, and so is a folder that takes no files") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "notes.txt", bytes_of("old")));
  const std::string blocker = fmt::format("'{}' is a file, and a folder is needed", folder / "notes.txt");
  for (const char* path : {"notes.txt/clip.json", "notes.txt/a/b.json"}) {
    const auto opened = posix_storage().open(folder / path);
    require_error(opened, ErrorCode::Permission);
    CHECK(opened.error().message.find(blocker) != std::string::npos);
  }
  const auto made = posix_storage().make_directories(folder / "notes.txt");
  require_error(made, ErrorCode::Permission);
  CHECK(made.error().message.find(blocker) != std::string::npos);
  const auto created = posix_storage().create("/proc/s.json", Creation::New);
  require_error(created, ErrorCode::Permission);
  CHECK(created.error().message.find("its folder takes no new files") != std::string::npos);
}

TEST_CASE("a folder whose link leads to none is told as not there, and not as one that is in the way") {
  const ScratchFolder folder;
  fs::create_directory_symlink("disk/out", folder / "out");
  for (const char* path : {"out", "out/today"}) {
    const auto made = posix_storage().make_directories(folder / path);
    require_error(made, ErrorCode::NotFound);
    CHECK(made.error().message.find("a link to a folder that is not there") != std::string::npos);
  }
}

TEST_CASE("the names of new folders are on the disk, as those of files are") {
  const ScratchFolder folder;
  const std::string real = fs::canonical(folder.name).string();
  std::vector<std::string> folders;
  synced = &folders;
  const Result<void> made = posix_storage().make_directories(folder / "a/b/c");
  const Result<void> again = posix_storage().make_directories(folder / "a/b/c");
  synced = nullptr;
  require_done(made);
  require_done(again);
  CHECK(folders == std::vector<std::string>{real, real + "/a", real + "/a/b"});
}

TEST_CASE("where the current folder was removed it is that which is told, not that the output is missing") {
  const std::string folder = test::scratch_folder("storage_removed");
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  std::filesystem::remove(folder);
  const auto seen = posix_storage().look_at("x.mp4");
  const auto elsewhere = posix_storage().look_at("/x.mp4");
  std::filesystem::current_path(here);
  REQUIRE_FALSE(seen.ok());
  CHECK(seen.error().code == ErrorCode::Io);
  CHECK(seen.error().message == "the current folder was removed; change to one that is there");
  CHECK(elsewhere.ok());
}

TEST_CASE("a name may be as long as the file system takes") {
  const ScratchFolder folder;
  const std::string longest(255, 'n');
  require_done(write_whole(posix_storage(), folder / longest.c_str(), bytes_of("all of it")));
  CHECK(test::text_of(folder / longest.c_str()) == "all of it");
}

TEST_CASE("a long name is not cut within a character while its file is made") {
  const ScratchFolder folder;
  const std::string character = "\xe8\xaa\x9e";  // of UTF-8, three bytes
  for (std::size_t before = 0; before < character.size(); ++before) {
    std::string name(before, 'n');
    while (name.size() + character.size() <= 255) name += character;
    const FileInMaking making = value_of(FileInMaking::beside(posix_storage(), folder / name.c_str()));
    const std::string cut = fs::path(making.path()).stem().stem().string().substr(1);
    CHECK(name.starts_with(cut));
    CHECK(cut.size() > 200);
    CHECK((cut.size() - before) % character.size() == 0);
  }
}

TEST_CASE("an error of a file in the making names the file that was asked for") {
  const ScratchFolder folder;
  fs::create_symlink("take1.mkv", folder / "latest.mkv");
  const FileInMaking making = value_of(FileInMaking::beside(posix_storage(), folder / "latest.mkv"));
  require_done(write_whole(posix_storage(), making.path(), bytes_of("somebody else's")));
  const auto made = making.as_asked(posix_storage().create(making.path(), Creation::New));
  require_error(made, ErrorCode::Exists);
  CHECK(made.error().message == fmt::format("'{}' exists already", folder / "latest.mkv"));
}

TEST_CASE("a FIFO is written through, not replaced") {
  const ScratchFolder folder;
  const std::string fifo = folder / "fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  std::string read;
  std::thread reader([&] {
    const int fd = ::open(fifo.c_str(), O_RDONLY);
    std::array<char, 64> buffer{};
    for (ssize_t n; (n = ::read(fd, buffer.data(), buffer.size())) > 0;)
      read.append(buffer.data(), static_cast<std::size_t>(n));
    ::close(fd);
  });
  const Result<void> written = write_whole(posix_storage(), fifo, bytes_of("statistics"));
  reader.join();
  require_done(written);
  CHECK(read == "statistics");
  CHECK(fs::is_fifo(fifo));
  CHECK_FALSE(FileInMaking::beside(posix_storage(), fifo).ok());
}

TEST_CASE("a FIFO that no program reads is waited for until somebody asks to stop") {
  const ScratchFolder folder;
  const std::string fifo = folder / "fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  std::atomic<bool> stop{false}, ended{false};
  const auto storage = stoppable_posix_storage(stop);
  Result<void> written;
  std::thread writer([&] {
    written = write_whole(*storage, fifo, bytes_of("statistics"));
    ended = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK_FALSE(ended);
  stop = true;
  const bool ended_in_time = test::becomes_true([&] { return ended.load(); });
  const Descriptor reader(ended_in_time ? -1 : ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  writer.join();
  CHECK(ended_in_time);
  require_error(written, ErrorCode::Interrupted);
  CHECK(written.error().message ==
        fmt::format("stopped while no program read the FIFO '{}'; start one that reads it, and run again",
                    fifo));
}

TEST_CASE("a standard output that does not block is waited for") {
  std::array<int, 2> ends{};
  REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0);
  REQUIRE(::fcntl(ends[1], F_SETFL, O_NONBLOCK) == 0);
  const int before = ::dup(STDOUT_FILENO);
  ::dup2(ends[1], STDOUT_FILENO), ::close(ends[1]);
  auto output = standard_output();
  ::dup2(before, STDOUT_FILENO), ::close(before);
  const std::string sent(1 << 20, 'x');  // more than a pipe holds
  std::string read;
  std::thread reader([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::array<char, 4096> buffer{};
    for (ssize_t n; (n = ::read(ends[0], buffer.data(), buffer.size())) > 0;)
      read.append(buffer.data(), static_cast<std::size_t>(n));
    ::close(ends[0]);
  });
  const Result<void> written = output->write_at(0, bytes_of(sent));
  output.reset();
  reader.join();
  require_done(written);
  CHECK(read == sent);
}

TEST_CASE("a standard output whose reader has ended is an error that says so") {
  std::array<int, 2> ends{};
  REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0);
  const int before = ::dup(STDOUT_FILENO);
  ::dup2(ends[1], STDOUT_FILENO), ::close(ends[1]);
  auto output = standard_output();
  ::dup2(before, STDOUT_FILENO), ::close(before);
  ::close(ends[0]);
  const auto earlier = std::signal(SIGPIPE, SIG_IGN);
  const Result<void> written = output->write_at(0, bytes_of("gone"));
  std::signal(SIGPIPE, earlier);
  require_error(written, ErrorCode::Io);
  CHECK(written.error().message == "the program that reads the standard output has ended");
}

TEST_CASE("a device is written through, not replaced") {
  require_done(write_whole(posix_storage(), "/dev/null", bytes_of("gone")));
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("a FIFO or a device in place of a file to read is refused at once, also through a link") {
  const ScratchFolder folder;
  REQUIRE(mkfifo((folder / "fifo").c_str(), 0600) == 0);  // nobody writes to it
  fs::create_symlink("fifo", folder / "link");
  for (const std::string& path : {folder / "fifo", folder / "link", std::string("/dev/null")}) {
    const auto text = read_whole(posix_storage(), path);
    require_error(text, ErrorCode::Permission);
    CHECK(text.error().message ==
          fmt::format("cannot read '{}': it is a device or a FIFO; name a regular file", path));
  }
}

TEST_CASE("a folder in place of a file is called a folder, to read and to write") {
  const ScratchFolder folder;
  const auto text = read_whole(posix_storage(), folder.name);
  require_error(text, ErrorCode::Permission);
  CHECK(text.error().message == fmt::format("cannot read '{}': it is a folder; name a file", folder.name));
  const Result<void> written = write_whole(posix_storage(), folder.name, bytes_of("text"));
  require_error(written, ErrorCode::Permission);
  CHECK(written.error().message ==
        fmt::format("cannot write '{}': it is a folder; name a file", folder.name));
}

TEST_CASE("two names of one file are the same file, also through links") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "one", bytes_of("1")));
  fs::create_symlink("one", folder / "soft");
  fs::create_hard_link(folder / "one", folder / "hard");
  const FileFacts one = value_of(posix_storage().look_at(folder / "one"));
  for (const char* other : {"soft", "hard"}) {
    const FileFacts facts = value_of(posix_storage().look_at(folder / other));
    CHECK(facts.device == one.device);
    CHECK(facts.inode == one.inode);
    CHECK(same_file(facts, one));
  }
}

TEST_CASE("a file is there under any of its names, and not where it cannot be told") {
  const ScratchFolder folder;
  require_done(write_whole(posix_storage(), folder / "one", bytes_of("1")));
  fs::create_symlink("one", folder / "link");
  fs::create_symlink("nowhere", folder / "dangling");
  for (const char* there : {"one", "link", "."}) CHECK(is_there(posix_storage(), folder / there));
  const std::string too_long = folder / std::string(300, 'n').c_str();
  REQUIRE_FALSE(posix_storage().look_at(too_long).ok());
  for (const std::string& missing : {folder / "two", folder / "dangling", too_long})
    CHECK_FALSE(is_there(posix_storage(), missing));
}

TEST_CASE("files are the same on one device only, missing ones at one path, and a new file is another") {
  FileFacts file{.kind = FileKind::Regular, .device = 1, .inode = 7, .real_path = "/a"}, other = file;
  other.real_path = "/b";
  CHECK(same_file(file, other));
  other.device = 2;  // where inodes are counted anew
  CHECK_FALSE(same_file(file, other));
  const FileFacts missing{.real_path = "/a"}, missing_elsewhere{.real_path = "/b"};
  CHECK(same_file(missing, missing));
  CHECK_FALSE(same_file(missing, missing_elsewhere));
  CHECK_FALSE(same_file(file, missing));
}

}  // namespace
}  // namespace hdrcam
