// What the stores need of a database: statements and rows, and turns to read and to write. SQLite
// and PostgreSQL implement it; what both do alike is in stores/.
//
// Statements are those of PostgreSQL: parameters are $1, $2, ..., truth is '= true' or '= false',
// and FOR NO KEY UPDATE locks rows. SQLite, where one thread writes at a time, translates them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace freelsd {

// Bytes that are bound as such, not as text.
struct Blob {
  std::string_view bytes;
};

// Of a parameter. Texts and bytes must live until the statement has run.
using Value = std::variant<bool,
                           int64_t,
                           double,
                           std::optional<int64_t>,
                           std::optional<double>,
                           std::string_view,
                           Blob>;
using Values = std::vector<Value>;

// A row of a result. Columns count from 0.
class Row {
 public:
  virtual bool IsNull(int column) const = 0;
  virtual int64_t Int(int column) const = 0;
  virtual double Real(int column) const = 0;
  // Empty for NULL.
  virtual std::string Text(int column) const = 0;

  bool Bool(int column) const { return Int(column) != 0; }
  std::optional<int64_t> OptionalInt(int column) const {
    return IsNull(column) ? std::nullopt : std::optional(Int(column));
  }
  std::optional<double> OptionalReal(int column) const {
    return IsNull(column) ? std::nullopt : std::optional(Real(column));
  }

 protected:
  ~Row() = default;
};

// A connection. Only one thread may use it at a time. Throws StorageError.
class Database {
 public:
  // Returns whether it wants the next row.
  using Visit = std::function<bool(const Row& row)>;

  virtual ~Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  virtual void Select(const std::string& sql, const Values& values, const Visit& visit) = 0;
  // Returns the number of rows that were inserted, updated or deleted.
  virtual int64_t Update(const std::string& sql, const Values& values) = 0;
  // Whether sites, maps and obstacles have a column `checksum`, because the database has none.
  virtual bool HasChecksums() const = 0;

  template <typename... Bound>
  int64_t Change(const std::string& sql, const Bound&... values) {
    return Update(sql, {Value(values)...});
  }
  // What `make` makes of each row.
  template <typename Make, typename... Bound>
  auto Each(const Make& make, const std::string& sql, const Bound&... values) {
    std::vector<std::invoke_result_t<Make, const Row&>> made;
    Select(sql, {Value(values)...}, [&](const Row& row) {
      made.push_back(make(row));
      return true;
    });
    return made;
  }
  // Of the first row, if there is one.
  template <typename Make, typename... Bound>
  auto First(const Make& make, const std::string& sql, const Bound&... values) {
    std::optional<std::invoke_result_t<Make, const Row&>> made;
    Select(sql, {Value(values)...}, [&](const Row& row) {
      made.emplace(make(row));
      return false;
    });
    return made;
  }
  // The first column of all rows.
  template <typename... Bound>
  std::vector<std::string> Texts(const std::string& sql, const Bound&... values) {
    return Each([](const Row& row) { return row.Text(0); }, sql, values...);
  }
  // The only number of the only row.
  template <typename... Bound>
  int64_t Int(const std::string& sql, const Bound&... values) {
    return First([](const Row& row) { return row.Int(0); }, sql, values...).value_or(0);
  }
  // Whether there is any row.
  template <typename... Bound>
  bool Has(const std::string& sql, const Bound&... values) {
    return First([](const Row&) { return true; }, sql, values...).has_value();
  }

 protected:
  Database() = default;
};

// From where rows are read, if there are two copies of sites, maps and obstacles (SQLite): from the
// main database; from there, or from the second copy if the main database is damaged; or the other
// way round, because damage can remove rows from the main database undetected.
enum class Reading { kMain, kSites, kRecall };

// What a commit changes. kUnseenMaps: rows of maps that are not in force, which no reader sees.
enum class Writing { kRows, kSites, kObstacles, kUnseenMaps };

// Whose change it is: kAbove, if the server that this one follows told it.
enum class Teller { kThisServer, kAbove };

// A transaction.
struct Writer {
  Database& database;
  // Of kUnseenMaps, which are written twice where there are two copies.
  bool is_second_copy = false;
  // Image files to remove after the commit: unless a frame or a photo tile refers to them, or even
  // if frames do.
  std::vector<std::string> unused_images = {};
  std::vector<std::string> retired_images = {};

  Database& operator*() const { return database; }
  Database* operator->() const { return &database; }
};

// What the databases state in different words. Empty statements are left out.
struct Dialect {
  // Column of flights: order of creation.
  std::string flight_number;
  // Gives a row if flight $1 may not lose its images now.
  std::string flight_in_use;
  // Column of frames: the image that a frame keeps. A column beside sha256 is NULL once the image
  // was given up.
  std::string frame_image;
  // The images that flight $1 gives up, and a statement that gives them up.
  std::string retired_images;
  std::string retire_images;
  // Flight $1 goes on.
  std::string forget_lost_workers;
  // Telemetry: as TelemetryStore::Recent of flight $1, kind $2 and $3 rows.
  std::string recent_telemetry;
  // The feed of changes: its highest number; statements before the first and before each new
  // number, and the new number.
  std::string last_change;
  std::string lock_changes;
  std::string step_change;
  std::string new_change;
  // Whether the server can follow another one.
  bool can_follow = false;
  // Tables of sites with what recall reads.
  std::string recallable_sites;
  // Whether there are two copies of sites, maps and obstacles.
  bool has_second_copy = false;
};

// A turn to change sites (SiteTurn). It ends with its write, or unused with its lifetime.
class Turn {
 public:
  virtual ~Turn() = default;
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  // As StoreAccess::Write of kSites.
  virtual void Write(Teller teller, const std::function<void(Writer&)>& act) = 0;

 protected:
  Turn() = default;
};

// A database with its image files. Thread-safe.
class StoreAccess {
 public:
  virtual ~StoreAccess() = default;
  StoreAccess(const StoreAccess&) = delete;
  StoreAccess& operator=(const StoreAccess&) = delete;

  virtual const Dialect& dialect() const = 0;
  virtual bool HasImage(const std::string& sha256) const = 0;
  // Increase with every change of a site, and of an obstacle.
  virtual uint64_t SitesVersion() = 0;
  virtual uint64_t ObstaclesVersion() = 0;
  // Waits for the turn.
  virtual std::unique_ptr<Turn> TakeTurn() = 0;
  // Of a new map of the flight. No other map has or had it since the storage was opened.
  virtual int64_t NextMapNumber(const std::string& flight_id) = 0;

  // Returns what `act` returns, which gets a Database and may run twice.
  template <typename Act>
  auto Read(const Act& act, Reading from = Reading::kMain) {
    std::optional<std::invoke_result_t<Act, Database&>> result;
    ReadWith(from, [&](Database& database) { result.emplace(act(database)); });
    return std::move(*result);
  }
  // Returns what `find` finds in the main database or in the second copy.
  template <typename Find>
  auto FindInEither(const Find& find) {
    auto found = Read(find, Reading::kSites);
    return found || !dialect().has_second_copy ? found : Read(find, Reading::kRecall);
  }
  // Runs `act` with a Writer and commits, unless it throws. Returns what it returns. For
  // kUnseenMaps it runs once for each copy.
  template <typename Act>
  auto Write(const Act& act, Writing what = Writing::kRows, Teller teller = Teller::kThisServer) {
    using Result = std::invoke_result_t<Act, Writer&>;
    if constexpr (std::is_void_v<Result>) {
      WriteWith(what, teller, act);
    } else {
      std::optional<Result> result;
      WriteWith(what, teller, [&](Writer& writer) { result.emplace(act(writer)); });
      return std::move(*result);
    }
  }

 protected:
  StoreAccess() = default;

 private:
  virtual void ReadWith(Reading from, const std::function<void(Database&)>& act) = 0;
  virtual void WriteWith(Writing what, Teller teller, const std::function<void(Writer&)>& act) = 0;
};

}  // namespace freelsd
