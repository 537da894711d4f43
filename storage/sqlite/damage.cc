#include "storage/sqlite/damage.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>

#include "storage/sqlite/changes.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr char kMarkName[] = "damaged";
constexpr char kCopyMarkName[] = "damaged-copy";
// Holds a SetAside of which no notice tells yet, each sentence in a line.
constexpr char kSetAsideName[] = "set-aside";
constexpr const char* kSuffixes[] = {"", "-wal", "-shm"};

struct Stamp {
  int64_t number = 0;
  int64_t application_id = 0;
};

// Nothing if the file does not exist.
std::optional<Stamp> StampOf(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  Connection connection(file, Access::kWrite);
  connection.Int("SELECT count(*) FROM sqlite_schema");
  return Stamp{connection.Int("PRAGMA user_version"), connection.Int("PRAGMA application_id")};
}

constexpr size_t kHeadBytes = 72;
using Head = std::array<char, kHeadBytes>;

// Big-endian, as all numbers of SQLite's files.
template <size_t kSize>
uint32_t NumberAt(const std::array<char, kSize>& bytes, size_t place) {
  uint32_t number = 0;
  for (size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<uint8_t>(bytes.at(place + i));
  return number;
}

// The beginning of the first page, the latest that the write-ahead log has, else that of the file.
// Without SQLite, which would write the log into the file. All 0 if there is none.
Head HeadOf(const std::filesystem::path& file) {
  Head head{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(head.data(), head.size())) head = {};
  std::ifstream log(file.string() + "-wal", std::ios::binary);
  std::array<char, 32> log_head{};
  if (!log.read(log_head.data(), log_head.size())) return head;
  const std::streamoff page_size = NumberAt(log_head, 8);
  std::array<char, 24> frame{};
  while (log.read(frame.data(), frame.size())) {
    const std::streampos next = log.tellg() + page_size;
    // Frames of other salts are of before.
    const bool is_current = NumberAt(frame, 8) == NumberAt(log_head, 16) &&
                            NumberAt(frame, 12) == NumberAt(log_head, 20);
    Head found{};
    if (is_current && NumberAt(frame, 0) == 1 && log.read(found.data(), found.size())) head = found;
    log.seekg(next);
  }
  return head;
}

// Nothing of a file that is not one of SQLite, because it is damaged.
Stamp StampInHead(const std::filesystem::path& file) {
  constexpr size_t kPlaceOfNumber = 60, kPlaceOfApplicationId = 68;
  const Head head = HeadOf(file);
  if (!std::string_view(head.data(), head.size()).starts_with("SQLite format 3")) return {};
  return {static_cast<int32_t>(NumberAt(head, kPlaceOfNumber)),
          static_cast<int32_t>(NumberAt(head, kPlaceOfApplicationId))};
}

// The first programs set no application_id.
bool IsOther(const Stamp& stamp) {
  const bool is_stated =
      stamp.application_id == ApplicationId(stamp.number) || stamp.application_id == 0;
  return stamp.number > 0 && stamp.number != kSchemaNumber && is_stated;
}

// Also nothing if the copy cannot be read, because it then proves nothing about the database.
std::optional<int64_t> NumberOfCopy(const std::filesystem::path& folder) {
  try {
    const std::optional<Stamp> stamp = StampOf(folder / kCopyName);
    return stamp ? std::optional(stamp->number) : std::nullopt;
  } catch (const StorageError&) {
    return std::nullopt;
  }
}

// Either file shows that another program wrote the folder: the other one may be lost or damaged.
void RefuseOther(const std::filesystem::path& folder) {
  const std::filesystem::path database = folder / kDatabaseName, copy = folder / kCopyName;
  const Stamp main = StampInHead(database), second = StampInHead(copy);
  const auto refuse = [](const std::filesystem::path& file, const Stamp& stamp) {
    throw OtherSchema("open " + file.string(), stamp.number, kSchemaNumber);
  };
  if (IsOther(main)) refuse(database, main);
  if (IsOther(second)) refuse(copy, second);
  const bool is_of_both = main.number == second.number && main.number > 0;
  if (is_of_both && main.number != kSchemaNumber) refuse(database, main);
}

// Nothing if there is no such file.
std::optional<std::string> ContentOf(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

std::optional<std::string> WhyDamaged(const std::filesystem::path& folder) {
  if (auto why = ContentOf(folder / kMarkName)) return why;
  std::optional<Stamp> stamp;
  try {
    stamp = StampOf(folder / kDatabaseName);
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    return error.what();
  }
  if (stamp && stamp->number == kSchemaNumber) return std::nullopt;
  // The copy is created after the database. If only the copy has this program's schema, the
  // database was lost or replaced. Files of other programs were refused before.
  const bool is_copy_current = NumberOfCopy(folder) == kSchemaNumber;
  const bool has_content = stamp && stamp->number != 0;
  const bool had_content = std::filesystem::exists(folder / kDatabaseFileName);
  if (!is_copy_current && (has_content || !had_content)) return std::nullopt;
  if (!stamp) return "its file is missing";
  return has_content ? "its schema number differs from its copy's" : "its file is empty";
}

// `is_database_lost`: the copy is then all that could be left.
std::optional<std::string> WhyCopyDamaged(const std::filesystem::path& folder,
                                          bool is_database_lost) {
  if (auto why = ContentOf(folder / kCopyMarkName)) return why;
  try {
    const std::optional<Stamp> stamp = StampOf(folder / kCopyName);
    if (!stamp || stamp->number == 0) {
      return is_database_lost ? std::optional("its file is missing or empty") : std::nullopt;
    }
    if (stamp->number != kSchemaNumber) return "its schema is not known";
    // Reads only the columns that each start needs: checking the whole file takes too long.
    Connection copy(folder / kCopyName, Access::kWrite);
    copy.Int("SELECT count(id) + max(updated_at_us) FROM sites");
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    return error.what();
  }
  return std::nullopt;
}

void Move(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::filesystem::exists(from)) std::filesystem::rename(from, to);
}

// Creates a folder with an unused name and returns the name.
std::string NewPlace(const std::filesystem::path& folder) {
  std::string name = "damaged-1";
  for (int i = 2; std::filesystem::exists(folder / name); ++i) {
    name = "damaged-" + std::to_string(i);
  }
  std::filesystem::create_directory(folder / name);
  return name;
}

void MoveDatabase(const std::filesystem::path& folder,
                  const std::string& database,
                  const std::string& place) {
  for (const char* suffix : kSuffixes) {
    const std::string file = database + suffix;
    Move(folder / file, folder / place / file);
  }
}

SetAside ReadSetAside(const std::filesystem::path& folder) {
  SetAside aside;
  std::ifstream stream(folder / kSetAsideName);
  std::getline(stream, aside.database);
  std::getline(stream, aside.copy);
  return aside;
}

void WriteSetAside(const std::filesystem::path& folder, const SetAside& aside) {
  std::ofstream(folder / kSetAsideName) << aside.database << '\n' << aside.copy << '\n';
}

// Adds a sentence about another damage.
void Add(std::string sentence, std::string& sentences) {
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  sentences += (sentences.empty() ? "" : "; ") + sentence;
}

}  // namespace

void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why) {
  // If this write fails, the next start has to detect the damage itself.
  std::ofstream(folder / kMarkName) << why;
}

void MarkCopy(const std::filesystem::path& folder, const std::string& why) {
  std::ofstream(folder / kCopyMarkName) << why;
}

SetAside SetAsideWhenDamaged(const std::filesystem::path& folder) {
  RefuseOther(folder);
  SetAside aside = ReadSetAside(folder);
  const std::optional<std::string> why = WhyDamaged(folder);
  const std::optional<std::string> why_copy =
      WhyCopyDamaged(folder, why || (!aside.database.empty() && aside.copy.empty()));
  if (!why && !why_copy) return aside;
  const std::string place = NewPlace(folder);
  if (why) {
    Add("the database was damaged (" + *why + "); what was left of it is in the folder " + place +
            ", with the images",
        aside.database);
  }
  if (why_copy) {
    Add("the second copy of the sites was damaged (" + *why_copy +
            "); what was left of it is in the folder " + place,
        aside.copy);
  }
  // First, so that a notice tells it whatever happens next.
  WriteSetAside(folder, aside);
  if (why) {
    MoveDatabase(folder, kDatabaseName, place);
    Move(folder / "images", folder / place / "images");
    std::filesystem::remove(folder / kMarkName);
  }
  if (why_copy) {
    MoveDatabase(folder, kCopyName, place);
    std::filesystem::remove(folder / kCopyMarkName);
  }
  return aside;
}

void ForgetSetAside(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove(folder / kSetAsideName, error);
}

}  // namespace freelsd
