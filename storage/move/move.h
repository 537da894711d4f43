// Rows as both databases have them, so that they can be moved and compared.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "storage/map_store.h"
#include "storage/obstacle_store.h"
#include "storage/site_store.h"

namespace freelsd {

enum class ColumnKind { kInt, kBool, kReal, kOptionalReal, kText, kBytes };

struct MovedColumn {
  std::string name;
  ColumnKind kind;
  // False: the databases round it differently.
  bool is_compared = true;
};

// NULL, an integer or bool, a real, text or bytes.
using MovedValue = std::variant<std::monostate, int64_t, double, std::string>;
using MovedRow = std::vector<MovedValue>;

struct MovedTable {
  std::string name;
  std::vector<MovedColumn> columns;
  // What follows "SELECT columns" in each database, with the same order of rows.
  std::string from_sqlite;
  std::string from_postgres;
};

// In the order of their foreign keys.
const std::vector<MovedTable>& MovedTables();
// The columns' names, by commas.
std::string ColumnList(const MovedTable& table);

using TakeRow = std::function<void(const MovedRow&)>;

// Where rows come from.
class RowSource {
 public:
  virtual ~RowSource() = default;
  RowSource(const RowSource&) = delete;
  RowSource& operator=(const RowSource&) = delete;

  virtual void ForEach(const MovedTable& table, const TakeRow& take) = 0;

 protected:
  RowSource() = default;
};

// Where rows go to: a place that is empty, or that an interrupted move has begun to fill. No server
// opens it until Complete. Rows that are there stay.
class RowTarget : public RowSource {
 public:
  // It holds a database already, which may only be compared.
  virtual bool IsComplete() const = 0;
  virtual void Put(const MovedTable& table, const MovedRow& row) = 0;
  // Ends a transaction and begins the next.
  virtual void Commit() = 0;
  virtual void PutImageRow(const std::string& sha256, int64_t num_bytes) = 0;
  virtual void Complete() = 0;
};

// Rows of tables that the stores write themselves, because other rows or checksums belong to them.
SiteRow SiteIn(const MovedRow& row);
FlightMapRow MapIn(const MovedRow& row);
ObstacleRow ObstacleIn(const MovedRow& row);

// All of these throw StorageError if a server uses the folder or the database.
// Of a folder with the current schema.
std::unique_ptr<RowSource> OpenSqliteSource(const std::filesystem::path& folder);
// Fills a file beside the database's own name, which Complete renames.
std::unique_ptr<RowTarget> OpenSqliteTarget(const std::filesystem::path& folder);
std::unique_ptr<RowSource> OpenPostgresSource(const std::string& url);
// While the move is unfinished, servers refuse the schema as another version's.
std::unique_ptr<RowTarget> OpenPostgresTarget(const std::string& url);

}  // namespace freelsd
