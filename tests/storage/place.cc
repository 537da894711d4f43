#include "tests/storage/place.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <stdexcept>

#include <libpq-fe.h>
#include <unistd.h>

namespace freelsd {
namespace {

std::string DatabaseUrl() {
  const char* const url = std::getenv("FREELSD_TEST_DATABASE");
  return url == nullptr ? "" : url;
}

// The first value of the last statement's rows; empty if it gives none.
std::string ExecuteAt(const std::string& url, const std::string& sql) {
  PGconn* const connection = PQconnectdb(url.c_str());
  PGresult* const result = PQexec(connection, sql.c_str());
  const ExecStatusType status = PQresultStatus(result);
  const std::string error = PQerrorMessage(connection);
  std::string value;
  if (status == PGRES_TUPLES_OK && PQntuples(result) > 0) value = PQgetvalue(result, 0, 0);
  PQclear(result);
  PQfinish(connection);
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) throw std::runtime_error(error);
  return value;
}

std::string UrlOf(const std::string& schema) {
  const std::string url = DatabaseUrl();
  const char separator = url.find('?') == std::string::npos ? '?' : '&';
  return url + separator + "options=-csearch_path%3D" + schema + "%2Cpublic";
}

std::string NewSchema() {
  static std::atomic<int> next{0};
  return "test_" + std::to_string(::getpid()) + "_" + std::to_string(next++);
}

DatabaseKind KindOfDatabase() {
  return DatabaseUrl().empty() ? DatabaseKind::kSqlite : DatabaseKind::kPostgres;
}

}  // namespace

StorageOptions StorageAt(const std::filesystem::path& folder) {
  // Guards schemas.
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::string> schemas;
  StorageOptions options;
  options.folder = folder;
  if (KindOfDatabase() == DatabaseKind::kSqlite) return options;
  const std::lock_guard lock(mutex);
  std::string& schema = schemas[folder];
  if (schema.empty()) {
    schema = NewSchema();
    ExecuteAt(DatabaseUrl(), "CREATE SCHEMA " + schema);
  }
  options.database_url = UrlOf(schema);
  options.images_folder = folder / "images";
  return options;
}

StoragePlace::StoragePlace() : schema_(NewSchema()) {
  if (Kind() == DatabaseKind::kPostgres) ExecuteAt(DatabaseUrl(), "CREATE SCHEMA " + schema_);
}

StoragePlace::~StoragePlace() {
  try {
    if (Kind() != DatabaseKind::kPostgres) return;
    ExecuteAt(DatabaseUrl(),
              "SET client_min_messages = warning; DROP SCHEMA " + schema_ + " CASCADE");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", schema_.c_str(), error.what());
  }
}

DatabaseKind StoragePlace::Kind() { return KindOfDatabase(); }

StorageOptions StoragePlace::options() const {
  StorageOptions options;
  options.folder = folder_.path();
  if (Kind() == DatabaseKind::kSqlite) return options;
  options.folder = folder_.path() / "data";
  options.database_url = UrlOf(schema_);
  options.images_folder = images_folder();
  options.unused_image_age_s = 0.0;
  return options;
}

StorageOptions StoragePlace::OptionsOfOne() const {
  StorageOptions one = options();
  one.is_shared = true;
  return one;
}

StorageOptions StoragePlace::OptionsOfOther() const {
  StorageOptions other = OptionsOfOne();
  other.folder = folder_.path() / "other";
  return other;
}

void StoragePlace::Execute(const std::string& sql) const { ExecuteAt(UrlOf(schema_), sql); }

std::string StoragePlace::Content() const {
  return ExecuteAt(UrlOf(schema_), "SELECT schema_to_xml('" + schema_ + "', true, false, '')");
}

}  // namespace freelsd
