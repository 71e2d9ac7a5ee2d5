#include "hal/storage.h"

#include <cerrno>
#include <filesystem>
#include <random>

#include "hal/core/split_text.h"

namespace hdrcam {
namespace {

// In the folder of `path`, so that a rename stays within one file system. std::random_device is the kernel's
// generator.
std::string unpredictable_name_beside(const std::string& path) {
  std::random_device random;
  const std::uint64_t number = (std::uint64_t{random()} << 32) | random();
  const std::filesystem::path beside(path);
  constexpr std::size_t kLongest = 255 - 23;  // bytes of a name that leave room for what is added
  const std::string name = beside.filename().string();
  const std::string_view beginning = first_characters(name, kLongest);  // FAT refuses a part of a character
  return (beside.parent_path() / fmt::format(".{}.{:016x}.part", beginning, number)).string();
}

}  // namespace

bool same_file(const FileFacts& a, const FileFacts& b) {
  if (a.kind == FileKind::Missing || b.kind == FileKind::Missing)
    return a.kind == b.kind && a.real_path == b.real_path;
  return a.device == b.device && a.inode == b.inode;
}

bool is_there(Storage& storage, const std::string& path) {
  const auto facts = storage.look_at(path);
  return facts && facts.value().kind != FileKind::Missing;
}

Result<void> sync_name(Storage& storage, const std::string& real_path) {
  const auto folder = storage.open(std::filesystem::path(real_path).parent_path());
  if (!folder) return {};
  Result<void> synced = folder.value()->sync();
  const int code = synced ? 0 : synced.error().sys_errno;
  const bool disk_fails = code == EIO || code == ENOSPC || code == EDQUOT;
  return disk_fails ? synced : Result<void>();  // else the file system does not sync folders
}

// Passes everything on.
class FileInMaking::File : public StorageFile {
 public:
  File(std::unique_ptr<StorageFile> file, Names names) : file_(std::move(file)), names_(std::move(names)) {}

  Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    return names_.as_asked(file_->read_at(offset, bytes));
  }
  Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes) override {
    return names_.as_asked(file_->write_at(offset, bytes));
  }
  Result<std::uint64_t> size() override { return names_.as_asked(file_->size()); }
  Result<void> sync() override { return names_.as_asked(file_->sync()); }
  Result<void> hold() override { return names_.as_asked(file_->hold()); }

 private:
  const std::unique_ptr<StorageFile> file_;
  const Names names_;
};

Result<FileInMaking> FileInMaking::beside(Storage& storage, const std::string& path) {
  FileFacts there = TRY(storage.look_at(path));
  if (there.kind == FileKind::Folder)
    return Error{ErrorCode::Permission, fmt::format("cannot write '{}': it is a folder; name a file", path)};
  if (there.kind == FileKind::Other)
    return Error{ErrorCode::Permission,
                 fmt::format("cannot write '{}': it is a device or a FIFO; name a regular file", path)};
  std::string making = unpredictable_name_beside(there.real_path);
  return FileInMaking(storage, std::move(making), std::move(there), path);
}

Result<FileInMaking> FileInMaking::beside_or_through(Storage& storage, const std::string& path) {
  FileFacts there = TRY(storage.look_at(path));
  if (there.kind == FileKind::Other) return FileInMaking(storage, path, std::move(there), path);
  return beside(storage, path);
}

FileInMaking::FileInMaking(FileInMaking&& other) noexcept
    : storage_(other.storage_),
      names_(std::move(other.names_)),
      earlier_(std::move(other.earlier_)),
      ours_(std::exchange(other.ours_, false)) {}

FileInMaking::~FileInMaking() {
  if (ours_) (void)storage_->remove(path());
}

Result<std::unique_ptr<StorageFile>> FileInMaking::create() const {
  if (is_through()) return storage_->create(path());
  auto file = TRY(as_asked(storage_->create(path(), Creation::New)));
  return std::unique_ptr<StorageFile>(std::make_unique<File>(std::move(file), names_));
}

Error FileInMaking::written_meanwhile(Forestalled forestalled) {
  const bool goes = forestalled == Forestalled::Goes;
  if (!goes) ours_ = false;
  return {
      ErrorCode::Exists,
      fmt::format("'{}' was written by another program meanwhile; it stays, and {}", names_.asked,
                  goes ? "this run has none; name another file" : fmt::format("this one is '{}'", path()))};
}

Result<void> FileInMaking::check_earlier(Forestalled forestalled) {
  const FileFacts now = TRY(storage_->look_at(earlier_.real_path));
  if (now.kind == FileKind::Missing) return {};
  if (!same_file(now, earlier_)) return written_meanwhile(forestalled);
  auto file = storage_->open(earlier_.real_path);  // one that nobody may read is replaced all the same
  return file ? names_.as_asked((*file)->hold()) : Result<void>();
}

Result<void> FileInMaking::commit(Durability durability, Forestalled forestalled) {
  if (is_through()) return {};
  if (durability == Durability::AtOnce) {
    const auto file = TRY(as_asked(storage_->open(path())));
    TRY(as_asked(file->sync()));
  }
  TRY(check_earlier(forestalled));
  // where nothing was, another program may still be the first, between that check and this line
  const Creation how = earlier_.kind == FileKind::Missing ? Creation::New : Creation::Replace;
  const Result<void> renamed = storage_->rename(path(), earlier_.real_path, how);
  if (!renamed && how == Creation::New && renamed.error().code == ErrorCode::Exists)
    return written_meanwhile(forestalled);
  TRY(renamed);
  ours_ = false;
  return durability == Durability::AtOnce ? sync_name(*storage_, earlier_.real_path) : Result<void>();
}

Result<void> write_whole(Storage& storage, const std::string& path, std::span<const std::byte> bytes,
                         Durability durability) {
  FileInMaking making = TRY(FileInMaking::beside_or_through(storage, path));
  const auto file = TRY(making.create());
  TRY(file->write_at(0, bytes));
  return making.commit(durability);
}

Result<std::string> read_whole(Storage& storage, const std::string& path) {
  constexpr std::uint64_t kMost = std::uint64_t{2} << 30;
  auto file = TRY(storage.open(path));
  const std::uint64_t size = TRY(file->size());
  if (size > kMost)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' is larger than 2 GiB, as no picture or document may be", path)};
  std::string text(size, '\0');
  const std::size_t n = TRY(file->read_at(0, std::as_writable_bytes(std::span(text))));
  text.resize(n);
  return text;
}

}  // namespace hdrcam
