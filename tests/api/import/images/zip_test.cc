#include <archive.h>
#include <archive_entry.h>
#include <doctest/doctest.h>
#include <unistd.h>

#include "api/import/images/images.h"
#include "tests/api/errors.h"
#include "tests/api/flights.h"

namespace freelsd {
namespace {

struct Entry {
  std::string name;
  std::string bytes;
  unsigned int type = AE_IFREG;
};

// A zip in the temporary folder, gone with the object.
class ZipFile {
 public:
  explicit ZipFile(const std::vector<Entry>& entries, const char* options = nullptr) {
    static int number = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("freelsd_zip_test_" + std::to_string(getpid()) + "_" + std::to_string(++number));
    archive* const written = archive_write_new();
    archive_write_set_format_zip(written);
    if (options != nullptr) {
      archive_write_set_passphrase(written, "secret");
      archive_write_set_options(written, options);
    }
    archive_write_open_filename(written, path_.c_str());
    for (const Entry& entry : entries) Write(written, entry);
    archive_write_free(written);
  }
  ~ZipFile() { std::filesystem::remove(path_); }
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void Overwrite(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

 private:
  static void Write(archive* written, const Entry& entry) {
    archive_entry* const header = archive_entry_new();
    archive_entry_set_pathname(header, entry.name.c_str());
    archive_entry_set_filetype(header, entry.type);
    archive_entry_set_perm(header, 0644);
    if (entry.type == AE_IFLNK) {
      archive_entry_set_symlink(header, entry.bytes.c_str());
    } else {
      archive_entry_set_size(header, static_cast<la_int64_t>(entry.bytes.size()));
    }
    archive_write_header(written, header);
    if (entry.type == AE_IFREG) archive_write_data(written, entry.bytes.data(), entry.bytes.size());
    archive_entry_free(header);
  }

  std::filesystem::path path_;
};

std::vector<Entry> Read(const ZipFile& zip, const ZipLimits& limits = {}) {
  std::vector<Entry> entries;
  ReadZip(zip.path().string(), limits, [&entries](const std::string& name, std::string&& bytes) {
    entries.push_back({name, std::move(bytes)});
  });
  return entries;
}

std::string ErrorOfZip(const std::vector<Entry>& entries, const ZipLimits& limits = {}) {
  const ZipFile zip(entries);
  int num_calls = 0;
  std::string error = ErrorOf([&] {
    ReadZip(zip.path().string(), limits, [&](const std::string&, std::string&&) { ++num_calls; });
  });
  // What the directory tells is refused before anything is handed out.
  if (error == "422 ZipRefused") CHECK(num_calls == 0);
  return error;
}

TEST_CASE("zip: plain files come in order with their paths, folders and leftovers do not") {
  const std::string large(300000, 'x');
  const ZipFile zip({{"flight/", "", AE_IFDIR},
                     {"flight/b 1.jpg", "second"},
                     {"__MACOSX/flight/._b 1.jpg", "junk"},
                     {"flight/.DS_Store", "junk"},
                     {"a.csv", large}});
  const ZipLimits limits{100, 1e4, 1 << 30, 1 << 30};
  const auto entries = Read(zip, limits);
  CHECK(ReadZip(zip.path().string(), limits, [](const auto&, auto&&) {}) == 2);
  REQUIRE(entries.size() == 2);
  CHECK(entries[0].name == "flight/b 1.jpg");
  CHECK(entries[0].bytes == "second");
  CHECK(entries[1].bytes == large);
}

TEST_CASE("zip: traversal, absolute paths, links and doubles are refused") {
  CHECK(ErrorOfZip({{"../a.jpg", "x"}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"a/../../b.jpg", "x"}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"a\\..\\b.jpg", "x"}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"/etc/passwd", "x"}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"C:\\a.jpg", "x"}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"good.jpg", "x"}, {"link.jpg", "/etc/passwd", AE_IFLNK}}) == "422 ZipRefused");
  CHECK(ErrorOfZip({{"a/1.jpg", "x"}, {"b/1.jpg", "y"}}) == "nothing");
  CHECK(ErrorOfZip({{"a..b.jpg", "x"}}) == "nothing");
  CHECK(ErrorOfZip({{"cam0/data.csv", "x"}, {"imu0/data.csv", "y"}}) == "nothing");
  CHECK(ErrorOfZip({{"a.csv", "x"}, {"a.csv", "y"}}) == "422 ZipRefused");
}

TEST_CASE("zip: over a limit it is 413") {
  const std::string zeros(1000000, '\0');
  CHECK(ErrorOfZip({{"a", zeros}}, ZipLimits{10, 200.0, 1 << 30, 1 << 30}) == "413 ZipTooLarge");
  CHECK(ErrorOfZip({{"a", zeros}}, ZipLimits{10, 1e9, 500000, 1 << 30}) == "413 ZipTooLarge");
  CHECK(ErrorOfZip({{"a", zeros}}, ZipLimits{10, 1e9, 1 << 30, 500000}) == "413 ZipTooLarge");
  CHECK(ErrorOfZip({{"a", "1"}, {"b", "2"}}, ZipLimits{1, 1e9, 1 << 30, 1 << 30}) ==
        "413 ZipTooLarge");
  CHECK(ErrorOfZip({{"a", zeros}}, ZipLimits{10, 1e9, 1 << 30, 1 << 30}) == "nothing");
}

TEST_CASE("zip: orthophotos, films and point clouds are named and not unpacked") {
  const std::string zeros(1000000, '\0');
  const ZipLimits small{10, 200.0, 1000, 1000};
  const ZipFile zip({{"a/map.TIF", zeros}, {"b/map.tif", zeros}, {"a.jpg", "image"}});
  const auto entries = Read(zip, ZipLimits{10, 1e9, 1000, 1000});
  REQUIRE(entries.size() == 3);
  CHECK(entries[0].name == "a/map.TIF");
  CHECK(entries[0].bytes.empty());
  CHECK(entries[2].bytes == "image");
  CHECK(ErrorOfZip({{"a.jpg", zeros}}, small) == "413 ZipTooLarge");
}

TEST_CASE("zip: kinds of files by their names") {
  CHECK(KindByName("a.b/c.PNG") == FileKind::kImage);
  CHECK(KindByName("geo.txt") == FileKind::kSideFile);
  CHECK(KindByName("LICENSE") == FileKind::kUnknown);
  CHECK(BeginsAsImage("\xFF\xD8\xFF\xE0"));
  CHECK_FALSE(BeginsAsImage("II*"));
  for (const char* const leftover : {"._DJI_0001.JPG",
                                     "DCIM/100MEDIA/._DJI_0001.JPG",
                                     "__MACOSX/a.jpg",
                                     "flight/@eaDir/a.jpg/thumb.jpg",
                                     "MISC/THM/100/DJI_0001.JPG",
                                     "a/Thumbs.db"}) {
    CAPTURE(std::string(leftover));
    CHECK(IsLeftover(leftover));
  }
  CHECK_FALSE(IsLeftover("a/.hidden.jpg"));
  CHECK_FALSE(IsLeftover("THM.jpg"));
}

// The archive with the flag that its names are UTF-8, as other programs write it.
void MarkNamesAsUtf8(const ZipFile& zip) {
  std::string bytes = ReadBytes(zip.path());
  for (const auto& [signature, flag_at] : {std::pair("PK\3\4", 7), {"PK\1\2", 9}}) {
    for (size_t at = bytes.find(signature); at != std::string::npos;
         at = bytes.find(signature, at + 1)) {
      bytes[at + static_cast<size_t>(flag_at)] |= 0x08;
    }
  }
  zip.Overwrite(bytes);
}

TEST_CASE("zip: names in any alphabet are read, with the flag of UTF-8 and without") {
  const std::vector<Entry> entries{{"\xC3\x9C"
                                    "berflug/DJI_0001.JPG",
                                    "a"},
                                   {"\xE8\x88\xAA\xE6\x8B\x8D/1.jpg", "b"},
                                   {"U\xCC\x88"
                                    "berflug/2.jpg",
                                    "c"},
                                   {"\xF0\x9F\x9A\x81.jpg", "d"},
                                   {"old \x9A.jpg", "e"}};
  for (const bool is_marked : {false, true}) {
    CAPTURE(is_marked);
    // The last name is no UTF-8.
    const ZipFile zip(is_marked ? std::vector<Entry>(entries.begin(), entries.end() - 1) : entries);
    if (is_marked) MarkNamesAsUtf8(zip);
    const std::vector<Entry> read = Read(zip);
    REQUIRE(read.size() == (is_marked ? 4 : 5));
    for (const size_t i : {0U, 1U, 3U}) CHECK(read[i].name == entries[i].name);
    // A letter and its accent become one character where the archive says that names are UTF-8.
    CHECK(read[2].name == (is_marked ? "\xC3\x9C"
                                       "berflug/2.jpg"
                                     : entries[2].name));
    for (size_t i = 0; i < read.size(); ++i) CHECK(read[i].bytes == entries[i].bytes);
  }
}

TEST_CASE("zip: encrypted, cut, damaged and no zip at all are refused") {
  const ZipFile encrypted({{"a.jpg", "secret"}}, "zip:encryption=traditional");
  CHECK(ErrorOf([&] { Read(encrypted); }) == "422 ZipRefused");
  uint32_t state = 3;
  std::string noise;
  for (int i = 0; i < 5000; ++i)
    noise += static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  const ZipFile zip({{"a.jpg", noise}});
  const std::string bytes = ReadBytes(zip.path());
  zip.Overwrite(bytes.substr(0, bytes.size() / 2));
  CHECK(ErrorOf([&] { Read(zip); }) == "422 ZipRefused");
  std::string damaged = bytes;
  damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 0xFF);
  zip.Overwrite(damaged);
  CHECK(ErrorOf([&] { Read(zip); }) == "422 ZipRefused");
  zip.Overwrite("image,latitude_deg\n");
  CHECK(ErrorOf([&] { Read(zip); }) == "422 ZipRefused");
  zip.Overwrite("");
  CHECK(ErrorOf([&] { Read(zip); }) == "422 ZipRefused");
}

}  // namespace
}  // namespace freelsd
