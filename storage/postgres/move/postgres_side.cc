#include <optional>

#include "storage/move/move.h"
#include "storage/postgres/area_rows.h"
#include "storage/postgres/organisations/organisations.h"
#include "storage/postgres/ownership.h"
#include "storage/postgres/pool.h"
#include "storage/postgres/schema.h"
#include "storage/postgres/site_rows.h"

namespace freelsd {
namespace {

// Higher than any schema's: a server refuses it.
constexpr char kUnfinishedVersion[] = "1000000000";
constexpr int kNumRowsOfFetch = 200;

StorageOptions OptionsOf(const std::string& url) {
  CheckDatabaseUrl(url);
  StorageOptions options;
  options.database_url = url;
  options.statement_timeout_s = 3600.0;
  return options;
}

MovedValue ValueAt(const PostgresRow& row, int column, ColumnKind kind) {
  switch (kind) {
    case ColumnKind::kInt:
    case ColumnKind::kBool:
      return row.Int(column);
    case ColumnKind::kReal:
      return row.Real(column);
    case ColumnKind::kOptionalReal:
      if (const auto value = row.OptionalReal(column)) return *value;
      return std::monostate();
    default:
      return row.Text(column);
  }
}

void ForEachRow(PostgresConnection& connection, const MovedTable& table, const TakeRow& take) {
  connection.Execute("DECLARE moved CURSOR FOR SELECT " + ColumnList(table) + table.from_postgres);
  MovedRow row(table.columns.size());
  for (;;) {
    const PostgresRows rows =
        connection.Run("FETCH " + std::to_string(kNumRowsOfFetch) + " FROM moved");
    if (rows.empty()) break;
    for (int i = 0; i < rows.size(); ++i) {
      for (size_t column = 0; column < row.size(); ++column) {
        row[column] = ValueAt(rows[i], static_cast<int>(column), table.columns[column].kind);
      }
      take(row);
    }
  }
  connection.Execute("CLOSE moved");
}

PostgresParameter ParameterOf(const MovedValue& value, ColumnKind kind) {
  if (kind == ColumnKind::kBytes) return freelsd::ParameterOf(Bytes{std::get<std::string>(value)});
  if (const auto* text = std::get_if<std::string>(&value)) return freelsd::ParameterOf(*text);
  if (const auto* integer = std::get_if<int64_t>(&value)) {
    return kind == ColumnKind::kBool ? freelsd::ParameterOf(*integer != 0)
                                     : freelsd::ParameterOf(*integer);
  }
  if (const auto* real = std::get_if<double>(&value)) return freelsd::ParameterOf(*real);
  return freelsd::ParameterOf(std::optional<double>());
}

void PutPlainRow(PostgresConnection& writer, const MovedTable& table, const MovedRow& row) {
  std::string names = ColumnList(table), marks;
  std::vector<PostgresParameter> values;
  for (size_t i = 0; i < row.size(); ++i) {
    marks += (i == 0 ? "$" : ", $") + std::to_string(i + 1);
    values.push_back(ParameterOf(row[i], table.columns[i].kind));
  }
  if (table.name == "frames") {
    names += ", stored_image";
    marks += ", (SELECT sha256 FROM images WHERE sha256 = $4)";
  }
  writer.RunPrepared("INSERT INTO " + table.name + " (" + names +
                         ") OVERRIDING SYSTEM VALUE VALUES (" + marks + ") ON CONFLICT DO NOTHING",
                     values);
}

void PutMap(PostgresConnection& writer, const MovedTable& table, const MovedRow& row) {
  const FlightMapRow map = MapIn(row);
  std::vector<PostgresParameter> values;
  for (size_t i = 0; i < row.size(); ++i) {
    values.push_back(ParameterOf(row[i], table.columns[i].kind));
  }
  const PostgresRows rows = writer.RunPrepared(
      "INSERT INTO maps (id, flight_id, head_json, altitude_datum, west_deg, south_deg, east_deg, "
      "north_deg, updated_at_us, seen_at_us, seen_until_us, number, is_in_force) VALUES ($1, $2, "
      "$3, $4, $5, $6, $7, $8, $9, $10, nullif($11, 0), "
      "coalesce(substring($1 from '/([0-9]+)$')::bigint, 0), true) ON CONFLICT DO NOTHING",
      values);
  if (rows.NumChanges() > 0) PutMapArea(writer, map.id, map.box);
}

void PutMovedObstacle(PostgresConnection& writer, const ObstacleRow& obstacle) {
  writer.Run(
      "INSERT INTO obstacles (id, feature_json, west_deg, south_deg, east_deg, north_deg, "
      "expires_at_us, updated_at_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT DO NOTHING",
      obstacle.id,
      obstacle.feature_json,
      obstacle.box.west_deg,
      obstacle.box.south_deg,
      obstacle.box.east_deg,
      obstacle.box.north_deg,
      obstacle.expires_at_us,
      obstacle.updated_at_us);
}

bool HasTable(PostgresConnection& connection, const std::string& name) {
  return connection.Run("SELECT to_regclass($1) IS NOT NULL", name)[0].Bool(0);
}

bool IsUnfinished(PostgresConnection& connection) {
  return HasTable(connection, "schema_migrations") &&
         connection
             .Run(std::string("SELECT EXISTS (SELECT 1 FROM schema_migrations WHERE version = ") +
                  kUnfinishedVersion + ")")[0]
             .Bool(0);
}

// A transaction lasts from one Commit to the next.
class PostgresSide : public RowTarget {
 public:
  explicit PostgresSide(const std::string& url)
      : pool_(OptionsOf(url)), owner_(pool_, OwnershipKind::kAlone), connection_(pool_) {
    // For as long as the connection lasts.
    connection_->Execute(std::string("SELECT set_config('freelsd.organisation', '") +
                         kDefaultOrganisation + "', false)");
  }
  ~PostgresSide() override = default;

  bool IsComplete() const override { return is_complete_; }
  void ForEach(const MovedTable& table, const TakeRow& take) override {
    ForEachRow(*connection_, table, take);
  }
  void Put(const MovedTable& table, const MovedRow& row) override;
  void Commit() override { connection_->Execute("COMMIT; BEGIN"); }
  void PutImageRow(const std::string& sha256, int64_t num_bytes) override {
    connection_->Run(
        "INSERT INTO images (sha256, num_bytes) VALUES ($1, $2) ON CONFLICT DO NOTHING",
        sha256,
        num_bytes);
  }
  void Complete() override;

  void BeginAsSource();
  void BeginAsTarget();

 private:
  bool HasRows();
  void RefuseUnknownColumns();
  void RefuseOtherOrganisations();

  bool is_complete_ = false;
  ConnectionPool pool_;
  Ownership owner_;
  ConnectionLease connection_;
};

void PostgresSide::BeginAsSource() {
  if (!HasTable(*connection_, "schema_migrations")) {
    throw StorageError("read the database", "freelsd has no tables there");
  }
  CreateSchema(*connection_);
  RefuseUnknownColumns();
  RefuseOtherOrganisations();
  connection_->Execute("BEGIN ISOLATION LEVEL REPEATABLE READ");
}

void PostgresSide::BeginAsTarget() {
  if (!IsUnfinished(*connection_)) {
    CreateSchema(*connection_);
    is_complete_ = HasRows();
  }
  if (!is_complete_ && !IsUnfinished(*connection_)) {
    connection_->Execute(std::string("INSERT INTO schema_migrations (version) VALUES (") +
                         kUnfinishedVersion + ")");
  }
  connection_->Execute("BEGIN");
}

bool PostgresSide::HasRows() {
  for (const char* table : {"flights", "sites", "maps", "obstacles", "images"}) {
    const std::string sql = std::string("SELECT EXISTS (SELECT 1 FROM ") + table + ")";
    if (connection_->Run(sql)[0].Bool(0)) return true;
  }
  return false;
}

// SQLite has no place for the values of columns that it lacks.
void PostgresSide::RefuseUnknownColumns() {
  for (const MovedTable& table : MovedTables()) {
    std::string known = ColumnList(table) +
                        ", number, organisation, stored_image, touchdown, area, is_in_force, "
                        "staged_at, superseded_by, superseded_at_us, "
                        "confirmed_at_us, expires_at_us";
    const std::vector<std::string> unknown =
        connection_
            ->Run(
                "SELECT column_name::text FROM information_schema.columns WHERE table_schema = "
                "current_schema() AND table_name = $1 AND column_name <> ALL "
                "(string_to_array($2, ', '))",
                table.name,
                known)
            .Texts();
    for (const std::string& column : unknown) {
      const std::string sql = "SELECT EXISTS (SELECT 1 FROM " + table.name + " WHERE " + column +
                              "::text NOT IN ('', '0', 'false'))";
      if (!connection_->Run(sql)[0].Bool(0)) continue;
      throw StorageError("move to SQLite", "it has no column " + table.name + "." + column);
    }
  }
}

void PostgresSide::RefuseOtherOrganisations() {
  connection_->Execute("BEGIN");
  ServeAllOrganisations(*connection_);
  const bool has_others = connection_
                              ->Run("SELECT EXISTS (SELECT 1 FROM organisations WHERE name <> $1)",
                                    std::string(kDefaultOrganisation))[0]
                              .Bool(0);
  connection_->Execute("ROLLBACK");
  if (has_others) {
    throw StorageError("move to SQLite", "the database has organisations, which SQLite has not");
  }
}

void PostgresSide::Put(const MovedTable& table, const MovedRow& row) {
  if (table.name == "sites") {
    PutSite(*connection_, SiteIn(row));
  } else if (table.name == "obstacles") {
    PutMovedObstacle(*connection_, ObstacleIn(row));
  } else if (table.name == "maps") {
    PutMap(*connection_, table, row);
  } else {
    PutPlainRow(*connection_, table, row);
  }
}

void PostgresSide::Complete() {
  connection_->Execute(
      "INSERT INTO map_numbers SELECT flight_id, max(number) FROM maps GROUP BY flight_id "
      "ON CONFLICT DO NOTHING;"
      "SELECT setval(pg_get_serial_sequence('jobs', 'number'), (SELECT coalesce(max(number), 0) + "
      "1 "
      "FROM jobs), false);"
      "UPDATE versions SET value = value + 1");
  connection_->Execute(std::string("DELETE FROM schema_migrations WHERE version = ") +
                       kUnfinishedVersion);
  connection_->Execute("COMMIT");
  connection_->Execute("ANALYZE");
}

}  // namespace

std::unique_ptr<RowSource> OpenPostgresSource(const std::string& url) {
  auto side = std::make_unique<PostgresSide>(url);
  side->BeginAsSource();
  return side;
}

std::unique_ptr<RowTarget> OpenPostgresTarget(const std::string& url) {
  auto side = std::make_unique<PostgresSide>(url);
  side->BeginAsTarget();
  return side;
}

}  // namespace freelsd
