#include <optional>

#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/move/move.h"
#include "storage/sqlite/changes/changes.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/obstacle_rows.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/site_standings.h"
#include "storage/storage.h"

extern const char* const kSchemaSql;

namespace freelsd {
namespace {

constexpr char kUnfinishedName[] = "freelsd-unfinished.db";

int64_t SqliteSchemaVersion(const Connection& connection) {
  Statement statement = connection.Prepare("PRAGMA user_version");
  statement.Step();
  return statement.Int(0);
}

MovedValue ValueAt(const Statement& statement, int column, ColumnKind kind) {
  switch (kind) {
    case ColumnKind::kInt:
    case ColumnKind::kBool:
      return statement.Int(column);
    case ColumnKind::kReal:
      return statement.Real(column);
    case ColumnKind::kOptionalReal:
      if (const auto value = statement.OptionalReal(column)) return *value;
      return std::monostate();
    default:
      return statement.Text(column);
  }
}

void ForEachRow(const Connection& connection, const MovedTable& table, const TakeRow& take) {
  const std::string sql = "SELECT " + ColumnList(table) + table.from_sqlite;
  Statement statement = connection.Prepare(sql.c_str());
  MovedRow row(table.columns.size());
  while (statement.Step()) {
    for (size_t i = 0; i < row.size(); ++i) {
      row[i] = ValueAt(statement, static_cast<int>(i), table.columns[i].kind);
    }
    take(row);
  }
}

void BindValue(Statement& statement, int index, ColumnKind kind, const MovedValue& value) {
  if (kind == ColumnKind::kBytes) {
    statement.BindOne(index, Blob{std::get<std::string>(value)});
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    statement.BindOne(index, *text);
  } else if (const auto* integer = std::get_if<int64_t>(&value)) {
    statement.BindOne(index, *integer);
  } else if (const auto* real = std::get_if<double>(&value)) {
    statement.BindOne(index, *real);
  } else {
    statement.BindOne(index, std::optional<double>());
  }
}

void PutPlainRow(const Connection& writer, const MovedTable& table, const MovedRow& row) {
  std::string marks;
  for (size_t i = 1; i <= row.size(); ++i) marks += (i == 1 ? "?" : ", ?") + std::to_string(i);
  const std::string sql =
      "INSERT OR IGNORE INTO " + table.name + " (" + ColumnList(table) + ") VALUES (" + marks + ")";
  Statement statement = writer.Prepare(sql.c_str());
  for (size_t i = 0; i < row.size(); ++i) {
    BindValue(statement, static_cast<int>(i) + 1, table.columns[i].kind, row[i]);
  }
  statement.Run();
}

void PutSite(const Connection& writer, const SiteRow& site) {
  PutSiteRows(writer, site);
  PutStandings(writer, {{site.id, site}});
}

class SqliteSource final : public RowSource {
 public:
  explicit SqliteSource(const std::filesystem::path& folder)
      : lock_(folder), connection_(folder / kDatabaseName, Access::kRead) {
    if (SqliteSchemaVersion(connection_) == kSchemaNumber) return;
    throw StorageError("read the database", "its schema is not this program's");
  }
  void ForEach(const MovedTable& table, const TakeRow& take) override {
    ForEachRow(connection_, table, take);
  }

 private:
  FolderLock lock_;
  Connection connection_;
};

class SqliteTarget final : public RowTarget {
 public:
  explicit SqliteTarget(const std::filesystem::path& folder) : folder_(folder), lock_(folder) {
    is_complete_ = std::filesystem::exists(folder / kDatabaseName);
    if (is_complete_) {
      writer_.emplace(folder / kDatabaseName, Access::kRead);
      return;
    }
    writer_.emplace(folder / kUnfinishedName, Access::kWrite);
    if (SqliteSchemaVersion(*writer_) == 0) MakeSchema();
    transaction_.emplace(*writer_);
  }
  bool IsComplete() const override { return is_complete_; }
  void ForEach(const MovedTable& table, const TakeRow& take) override {
    ForEachRow(*writer_, table, take);
  }
  void Put(const MovedTable& table, const MovedRow& row) override {
    if (table.name == "sites") {
      PutSite(*writer_, SiteIn(row));
    } else if (table.name == "obstacles") {
      PutObstacleRow(*writer_, ObstacleIn(row));
    } else if (table.name == "maps") {
      const FlightMapRow map = MapIn(row);
      if (!FindMapRow(*writer_, map.id)) PutMapRow(*writer_, map, true);
    } else {
      PutPlainRow(*writer_, table, row);
    }
  }
  void Commit() override {
    transaction_->Commit();
    transaction_.emplace(*writer_);
  }
  void PutImageRow(const std::string& /*sha256*/, int64_t /*num_bytes*/) override {}
  void Complete() override;

 private:
  void MakeSchema() {
    Transaction transaction(*writer_);
    writer_->Execute(kSchemaSql);
    writer_->Execute(("PRAGMA application_id = " + std::to_string(ApplicationId(kSchemaNumber)) +
                      "; PRAGMA user_version = " + std::to_string(kSchemaNumber))
                         .c_str());
    transaction.Commit();
  }

  bool is_complete_ = false;
  std::filesystem::path folder_;
  std::optional<FolderLock> lock_;
  std::optional<Connection> writer_;
  std::optional<Transaction> transaction_;
};

void SqliteTarget::Complete() {
  transaction_->Commit();
  transaction_.reset();
  // The last connection moves the write-ahead log into the file.
  writer_.reset();
  std::filesystem::rename(folder_ / kUnfinishedName, folder_ / kDatabaseName);
  SyncFolder(folder_);
  lock_.reset();
  // Makes the second copy of the sites.
  const Storage storage(folder_);
}

}  // namespace

std::unique_ptr<RowSource> OpenSqliteSource(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / kDatabaseName)) {
    throw StorageError("read " + folder.string(), "there is no database");
  }
  return std::make_unique<SqliteSource>(folder);
}

std::unique_ptr<RowTarget> OpenSqliteTarget(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return std::make_unique<SqliteTarget>(folder);
}

}  // namespace freelsd
