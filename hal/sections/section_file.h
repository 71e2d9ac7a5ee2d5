// A file of named sections, each with its length and a checksum, so that a cut or damaged file is told before
// anything of it is used, and no length is believed that the file cannot hold. Little-endian:
//   file     magic [8], version u32, sections, the last of which is the empty one "end"
//   section  name [16] padded with zeros, length u64, CRC-32 of the content u32,
//            CRC-32 of these 28 bytes u32, content
// Checksums are zlib's, as in recordings. Thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/sections/fields.h"
#include "hal/storage.h"

namespace hdrcam {

struct SectionFormat {
  std::string_view what;  // "a snapshot of a scene"
  std::array<char, 8> magic;
  std::uint32_t version;  // that is written; a newer one is refused
  std::string_view mend;  // what to do about a damaged file: "copy it again, or save it again"
};

using Bytes = std::span<const std::byte>;

class SectionWriter {
 public:
  // The file gets its name with finish(). Its storage outlives the writer. Errors: those of the disk.
  static Result<SectionWriter> create(FileInMaking making, const SectionFormat& format);

  // name: 1 to 16 ASCII characters; parts: the content, in pieces. Errors: NoSpace, Io.
  Result<void> add(std::string_view name, std::span<const Bytes> parts);
  Result<void> add(std::string_view name, Bytes content) { return add(name, std::span(&content, 1)); }
  // Completes the file. Errors: those of FileInMaking::commit.
  Result<void> finish();

 private:
  SectionWriter(FileInMaking making, std::unique_ptr<StorageFile> file)
      : making_(std::move(making)), file_(std::move(file)) {}
  Result<void> append(Bytes bytes);

  FileInMaking making_;
  std::unique_ptr<StorageFile> file_;
  std::uint64_t end_ = 0;
};

// Whether the file begins as one of this format; a folder does not. Errors: those of Storage::look_at,
// Storage::open and of reading.
Result<bool> is_section_file(Storage& storage, const std::string& path, const SectionFormat& format);

class SectionReader {
 public:
  // Errors: those of the disk; NotRecording for another file; Unsupported for a newer version; Truncated.
  static Result<SectionReader> open(Storage& storage, const std::string& path, const SectionFormat& format);

  // Begins the next section and returns its name. Its content is in the file as a whole. Errors: Truncated,
  // Corrupt, those of the disk.
  Result<std::string> next();
  // Begins the next section, which has this name. Errors: those of next().
  Result<void> begin(std::string_view name);
  std::uint64_t length() const { return length_; }  // of the section that was begun
  // Its content, piece by piece, which the section holds.
  Result<void> read(std::span<std::byte> bytes);
  // Ends the section, all of which was read. Errors: Corrupt for a wrong checksum.
  Result<void> end();
  // Reads all sections that follow, for their checksums alone, and the end. Errors: those of next() and
  // end().
  Result<void> pass_to_end();
  // The whole section as the fields of `values`, and its end. Errors: also Corrupt where they do not fill it.
  template <class T>
  Result<void> read_fields(T& values) {
    constexpr std::uint64_t kMost = 16 << 20;  // small values
    if (length_ > kMost) return wrong("it is too large");
    std::vector<std::byte> bytes(static_cast<std::size_t>(length_));
    TRY(read(bytes));
    TRY(end());
    FieldsIn fields(bytes);
    fields(values);
    return fields.complete() ? Result<void>() : wrong("its values do not fill it");
  }
  // The section "end". Errors: those of next(); Corrupt where another stands there, or something follows it.
  Result<void> end_of_file();

  // Corrupt, naming the file and the section. what: a clause, "it has 3 curves of 5".
  Error wrong(std::string_view what) const;

 private:
  SectionReader(std::unique_ptr<StorageFile> file, std::string path, const SectionFormat& format)
      : file_(std::move(file)), path_(std::move(path)), format_(format) {}
  Result<void> pass();
  Result<void> check_last() const;
  Result<void> read_here(std::span<std::byte> bytes);

  std::unique_ptr<StorageFile> file_;
  std::string path_;
  SectionFormat format_;
  std::uint64_t size_ = 0, at_ = 0;  // of the file, and the next byte
  std::string name_;                 // of the section
  std::uint64_t length_ = 0, left_ = 0;
  std::uint32_t stated_ = 0, crc_ = 0;
};

}  // namespace hdrcam
