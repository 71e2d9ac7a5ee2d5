#include "hal/sections/section_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <vector>

namespace hdrcam {
namespace {

constexpr std::string_view kEnd = "end";
constexpr std::size_t kNameLength = 16;
constexpr std::size_t kMagicLength = 8;

struct SectionHead {
  std::array<char, kNameLength> name{};
  std::uint64_t length = 0;
  std::uint32_t content_crc = 0, head_crc = 0;
};
static_assert(sizeof(SectionHead) == 32);

std::uint32_t checksum(std::uint32_t before, Bytes bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint32_t crc_of(const SectionHead& head) {
  return checksum(0, std::as_bytes(std::span(&head, 1)).first(offsetof(SectionHead, head_crc)));
}

std::string text_of(const std::array<char, kNameLength>& name) {
  return {name.begin(), std::ranges::find(name, '\0')};
}

}  // namespace

Result<SectionWriter> SectionWriter::create(FileInMaking making, const SectionFormat& format) {
  auto file = TRY(making.create());
  SectionWriter writer(std::move(making), std::move(file));
  TRY(writer.append(std::as_bytes(std::span(format.magic))));
  TRY(writer.append(std::as_bytes(std::span(&format.version, 1))));
  return writer;
}

Result<void> SectionWriter::append(Bytes bytes) {
  TRY(file_->write_at(end_, bytes));
  end_ += bytes.size();
  return {};
}

Result<void> SectionWriter::add(std::string_view name, std::span<const Bytes> parts) {
  HDRCAM_CHECK(!name.empty() && name.size() <= kNameLength);
  SectionHead head;
  std::ranges::copy(name, head.name.begin());
  for (const Bytes part : parts) {
    head.length += part.size();
    head.content_crc = checksum(head.content_crc, part);
  }
  head.head_crc = crc_of(head);
  TRY(append(std::as_bytes(std::span(&head, 1))));
  for (const Bytes part : parts) TRY(append(part));
  return {};
}

Result<void> SectionWriter::finish() {
  TRY(add(kEnd, Bytes()));
  file_.reset();
  return making_.commit();
}

Result<bool> is_section_file(Storage& storage, const std::string& path, const SectionFormat& format) {
  if (TRY(storage.look_at(path)).kind == FileKind::Folder) return false;
  const auto file = TRY(storage.open(path));
  std::array<char, kMagicLength> magic{};
  const std::size_t n = TRY(file->read_at(0, std::as_writable_bytes(std::span(magic))));
  return n == magic.size() && magic == format.magic;
}

Result<SectionReader> SectionReader::open(Storage& storage, const std::string& path,
                                          const SectionFormat& format) {
  if (!TRY(is_section_file(storage, path, format)))
    return Error{ErrorCode::NotRecording, fmt::format("'{}' is not {}", path, format.what)};
  SectionReader reader(TRY(storage.open(path)), path, format);
  reader.size_ = TRY(reader.file_->size());
  reader.at_ = kMagicLength;
  std::uint32_t version = 0;
  TRY(reader.read_here(std::as_writable_bytes(std::span(&version, 1))));
  if (version > format.version)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' is {} of version {}, and this program reads up to version {}; take the "
                             "newer hdrcam that wrote it",
                             path, format.what, version, format.version)};
  if (version == 0) return reader.wrong("its version is 0");
  return reader;
}

Error SectionReader::wrong(std::string_view what) const {
  const std::string where = name_.empty() ? std::string() : fmt::format(" in its section '{}'", name_);
  return {ErrorCode::Corrupt, fmt::format("'{}' is damaged{}: {}; {}", path_, where, what, format_.mend)};
}

Result<void> SectionReader::read_here(std::span<std::byte> bytes) {
  const bool whole = bytes.size() <= size_ - at_;
  if (whole && TRY(file_->read_at(at_, bytes)) == bytes.size()) {
    at_ += bytes.size();
    return {};
  }
  return Error{ErrorCode::Truncated,
               fmt::format("'{}' is truncated: {} bytes of {}, {}; {}", path_, size_, format_.what,
                           name_.empty() ? std::string("which ends before its first section")
                                         : fmt::format("which ends in or after its section '{}'", name_),
                           format_.mend)};
}

Result<std::string> SectionReader::next() {
  HDRCAM_CHECK_EQ(left_, std::uint64_t{0});
  SectionHead head;
  TRY(read_here(std::as_writable_bytes(std::span(&head, 1))));
  if (head.head_crc != crc_of(head)) {
    name_.clear();
    return wrong(fmt::format("no section begins at byte {}", at_ - sizeof head));
  }
  name_ = text_of(head.name);
  length_ = left_ = head.length, stated_ = head.content_crc, crc_ = 0;
  if (length_ > size_ - at_) {
    left_ = 0;
    return Error{ErrorCode::Truncated,
                 fmt::format("'{}' is truncated: its section '{}' has {} of {} bytes; {}", path_, name_,
                             size_ - at_, length_, format_.mend)};
  }
  return name_;
}

Result<void> SectionReader::begin(std::string_view name) {
  if (TRY(next()) == name) return {};
  left_ = 0;
  return wrong(fmt::format("'{}' should stand in its place", name));
}

Result<void> SectionReader::read(std::span<std::byte> bytes) {
  HDRCAM_CHECK(bytes.size() <= left_);
  TRY(read_here(bytes));
  left_ -= bytes.size();
  crc_ = checksum(crc_, bytes);
  return {};
}

Result<void> SectionReader::end() {
  HDRCAM_CHECK_EQ(left_, std::uint64_t{0});
  return crc_ == stated_ ? Result<void>() : wrong("its checksum is wrong");
}

Result<void> SectionReader::pass() {
  constexpr std::uint64_t kPiece = 1 << 20;
  std::vector<std::byte> piece(static_cast<std::size_t>(std::min(left_, kPiece)));
  while (left_ > 0) TRY(read(std::span(piece).first(static_cast<std::size_t>(std::min(left_, kPiece)))));
  return end();
}

Result<void> SectionReader::pass_to_end() {
  while (TRY(next()) != kEnd) TRY(pass());
  return check_last();
}

Result<void> SectionReader::end_of_file() {
  TRY(begin(kEnd));
  return check_last();
}

Result<void> SectionReader::check_last() const {
  return length_ > 0 || at_ < size_ ? wrong("bytes follow it") : Result<void>();
}

}  // namespace hdrcam
