#include <algorithm>
#include <fstream>
#include <memory>
#include <set>
#include <stdexcept>

#include <archive.h>
#include <archive_entry.h>
#include <locale.h>
#include <sys/stat.h>

#include "api/import/images/images.h"
#include "api/import/import.h"

namespace freelsd {
namespace {

constexpr size_t kReadBlockBytes = 1 << 16;

struct CloseArchive {
  void operator()(archive* opened) const { archive_read_free(opened); }
};
using Archive = std::unique_ptr<archive, CloseArchive>;

// The library converts names to the thread's locale, and has no name in the plain one.
class Utf8Names {
 public:
  Utf8Names()
      : utf8_(newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)),
        before_(uselocale(utf8_ == nullptr ? LC_GLOBAL_LOCALE : utf8_)) {}
  ~Utf8Names() {
    uselocale(before_);
    if (utf8_ != nullptr) freelocale(utf8_);
  }
  Utf8Names(const Utf8Names&) = delete;
  Utf8Names& operator=(const Utf8Names&) = delete;

 private:
  locale_t utf8_;
  locale_t before_;
};

ApiError Refused(const std::string& detail) { return ApiError("ZipRefused", detail); }

ApiError FileTooLarge(const std::string& detail, double limit, double observed) {
  ApiError error("ZipTooLarge", detail);
  error.limit = limit;
  error.observed = observed;
  return error;
}

Archive Open(const std::string& path) {
  Archive opened(archive_read_new());
  if (!opened) throw std::runtime_error("libarchive: out of memory");
  archive_read_support_format_zip(opened.get());
  if (archive_read_open_filename(opened.get(), path.c_str(), kReadBlockBytes) != ARCHIVE_OK) {
    throw Refused("not a readable zip archive");
  }
  return opened;
}

// The next entry; nothing at the end. A name outside the locale's character set is only a warning.
archive_entry* NextEntry(const Archive& opened) {
  archive_entry* entry = nullptr;
  const int result = archive_read_next_header(opened.get(), &entry);
  if (result == ARCHIVE_EOF) return nullptr;
  if (result != ARCHIVE_OK && result != ARCHIVE_WARN) {
    throw Refused("the zip archive is damaged or truncated");
  }
  return entry;
}

std::string NameOf(archive_entry* entry) {
  const char* name = archive_entry_pathname_utf8(entry);
  if (name == nullptr) name = archive_entry_pathname(entry);
  if (name == nullptr || *name == '\0') throw Refused("an entry of the zip archive has no name");
  return name;
}

void CheckName(const std::string& name) {
  const bool is_absolute = name[0] == '/' || name[0] == '\\' || (name.size() > 1 && name[1] == ':');
  if (is_absolute) throw Refused("an entry of the zip archive has an absolute path");
  size_t start = 0;
  while (start <= name.size()) {
    const size_t end = std::min(name.find_first_of("/\\", start), name.size());
    if (name.compare(start, end - start, "..") == 0) {
      throw Refused("an entry of the zip archive leaves its folder");
    }
    start = end + 1;
  }
}

// Whether the entry is a file that is wanted. Refuses entries that are not plain files.
bool IsWanted(archive_entry* entry, const std::string& name) {
  CheckName(name);
  const auto type = archive_entry_filetype(entry);
  if (type == AE_IFDIR || IsLeftover(name)) return false;
  if (type != AE_IFREG || archive_entry_hardlink(entry) != nullptr ||
      archive_entry_symlink(entry) != nullptr) {
    throw Refused("an entry of the zip archive is not a plain file");
  }
  if (archive_entry_is_encrypted(entry) != 0) throw Refused("the zip archive is encrypted");
  return true;
}

// Counts the unpacked bytes because a directory may state wrong sizes.
class Allowance {
 public:
  Allowance(const std::string& path, const ZipLimits& limits) : limits_(limits) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) throw std::runtime_error("zip: the file is gone");
    max_total_ = static_cast<double>(limits.max_total_bytes);
    max_total_by_ratio_ = limits.max_ratio * static_cast<double>(status.st_size);
  }

  void Take(size_t entry_bytes, size_t new_bytes) {
    total_ += static_cast<double>(new_bytes);
    if (entry_bytes > limits_.max_entry_bytes) {
      throw FileTooLarge("an entry of the zip archive is too large",
                         static_cast<double>(limits_.max_entry_bytes),
                         static_cast<double>(entry_bytes));
    }
    if (total_ > max_total_) {
      throw FileTooLarge("the zip archive unpacks to too much", max_total_, total_);
    }
    if (total_ > max_total_by_ratio_) {
      throw FileTooLarge(
          "the zip archive's compression ratio is too high", max_total_by_ratio_, total_);
    }
  }

 private:
  ZipLimits limits_;
  double max_total_ = 0.0;
  double max_total_by_ratio_ = 0.0;
  double total_ = 0.0;
};

// Number of entries in the end record. Larger archives (zip64) exceed every limit. The check is
// first because the library reads the whole directory before it returns the first entry.
int NumEntriesTold(const std::string& path) {
  constexpr std::streamoff kMaxEndBytes = 22 + 65535;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  const std::streamoff begin = std::max<std::streamoff>(0, size - kMaxEndBytes);
  std::string end(static_cast<size_t>(std::max<std::streamoff>(0, size - begin)), '\0');
  file.seekg(begin);
  file.read(end.data(), static_cast<std::streamsize>(end.size()));
  const size_t at = end.rfind("PK\5\6");
  // Without an end record the library decides.
  if (at == std::string::npos || at + 12 > end.size()) return 0;
  return static_cast<unsigned char>(end[at + 10]) | static_cast<unsigned char>(end[at + 11]) << 8;
}

void RefuseTooMany(int num_entries, const ZipLimits& limits) {
  if (num_entries <= limits.max_entries) return;
  throw FileTooLarge("too many entries in the zip archive", limits.max_entries, num_entries);
}

// Checks the whole directory before the first entry is passed on.
void CheckDirectory(const std::string& path, const ZipLimits& limits) {
  RefuseTooMany(NumEntriesTold(path), limits);
  Allowance allowance(path, limits);
  const Archive opened = Open(path);
  std::set<std::string> names;
  int num_entries = 0;
  while (archive_entry* const entry = NextEntry(opened)) {
    RefuseTooMany(++num_entries, limits);
    const std::string name = NameOf(entry);
    if (!IsWanted(entry, name)) continue;
    if (KindByName(name) == FileKind::kUnread) continue;
    // A zip bomb may state its true size.
    const auto told = static_cast<size_t>(std::max<int64_t>(0, archive_entry_size(entry)));
    allowance.Take(told, told);
    if (!names.insert(name).second) {
      throw Refused("two entries of the zip archive are called \"" + ShownPath(name) + "\"");
    }
  }
}

std::string ReadEntry(const Archive& opened, archive_entry* entry, Allowance& allowance) {
  const bool is_told = archive_entry_size_is_set(entry) != 0;
  const auto told = static_cast<size_t>(std::max<int64_t>(0, archive_entry_size(entry)));
  std::string bytes;
  std::string block(kReadBlockBytes, '\0');
  while (true) {
    const la_ssize_t count = archive_read_data(opened.get(), block.data(), block.size());
    if (count == 0) return bytes;
    if (count < 0) throw Refused("an entry of the zip archive is damaged");
    allowance.Take(bytes.size() + static_cast<size_t>(count), static_cast<size_t>(count));
    if (is_told && bytes.size() + static_cast<size_t>(count) > told) {
      throw Refused("an entry of the zip archive is larger than its directory says");
    }
    bytes.append(block.data(), static_cast<size_t>(count));
  }
}

}  // namespace

size_t ReadZip(const std::string& path,
               const ZipLimits& limits,
               const std::function<void(const std::string& path, std::string&& bytes)>& entry) {
  const Utf8Names names;
  CheckDirectory(path, limits);
  Allowance allowance(path, limits);
  const Archive opened = Open(path);
  size_t num_leftovers = 0;
  while (archive_entry* const next = NextEntry(opened)) {
    const std::string name = NameOf(next);
    if (!IsWanted(next, name)) {
      num_leftovers += archive_entry_filetype(next) == AE_IFDIR ? 0 : 1;
      continue;
    }
    const bool is_read = KindByName(name) != FileKind::kUnread;
    entry(name, is_read ? ReadEntry(opened, next, allowance) : "");
  }
  return num_leftovers;
}

}  // namespace freelsd
