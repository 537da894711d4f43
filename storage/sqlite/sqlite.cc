#include "storage/sqlite/sqlite.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "storage/storage_error.h"

namespace freelsd {
namespace {

// How long a connection waits for a lock. With a single writer, only a checkpoint makes it wait.
constexpr int kBusyTimeoutMs = 2000;

// SQLite reports only ENOSPC as full; an exceeded quota or file size limit is an I/O error.
StorageFault FaultOf(sqlite3* database, int code) {
  if (code == SQLITE_FULL) return StorageFault::kFull;
  if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB) return StorageFault::kDamaged;
  // Two kinds of damage have no error code of their own: an invalid file header, and a changed
  // schema. SQLite reports the second kind as "no such table" or "no such column", although our
  // statements name only what the schema has.
  if (code == SQLITE_ERROR && database != nullptr) {
    const std::string_view message = sqlite3_errmsg(database);
    if (message == "unsupported file format" || message.starts_with("no such ")) {
      return StorageFault::kDamaged;
    }
  }
  if (database == nullptr || code != SQLITE_IOERR) return StorageFault::kOther;
  const int error = sqlite3_system_errno(database);
  return error == EDQUOT || error == EFBIG ? StorageFault::kFull : StorageFault::kOther;
}

[[noreturn]] void Fail(sqlite3* database, const std::string& step) {
  const int code = database == nullptr ? SQLITE_NOMEM : sqlite3_errcode(database);
  const std::string reason =
      database == nullptr ? "out of memory" : std::string(sqlite3_errmsg(database));
  throw StorageError(step, reason, FaultOf(database, code));
}

// The beginning of the statement, for error messages; it contains no values.
std::string StepName(const std::string& sql) { return sql.substr(0, sql.find_first_of("(\n")); }

void ReplaceAll(std::string_view from, std::string_view to, std::string& text) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// From PostgreSQL's words to those of SQLite.
std::string Translated(std::string sql) {
  ReplaceAll("$", "?", sql);
  ReplaceAll(" = true", " = 1", sql);
  ReplaceAll(" = false", " = 0", sql);
  ReplaceAll(" FOR NO KEY UPDATE", "", sql);
  return sql;
}

// Binds a value to ?index of a statement. Returns SQLite's result.
struct Binding {
  int operator()(bool value) const { return (*this)(int64_t{value}); }
  int operator()(int64_t value) const { return sqlite3_bind_int64(statement, index, value); }
  int operator()(double value) const { return sqlite3_bind_double(statement, index, value); }
  template <typename Number>
  int operator()(const std::optional<Number>& value) const {
    return value ? (*this)(*value) : sqlite3_bind_null(statement, index);
  }
  int operator()(std::string_view value) const {
    return sqlite3_bind_text64(
        statement, index, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  int operator()(const Blob& value) const {
    return sqlite3_bind_blob64(
        statement, index, value.bytes.data(), value.bytes.size(), SQLITE_TRANSIENT);
  }

  sqlite3_stmt* statement;
  int index;
};

}  // namespace

Statement::Statement(sqlite3* database, const char* sql) : database_(database) {
  if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) {
    Fail(database, StepName(sql));
  }
}

Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::Check(int result) const {
  if (result != SQLITE_OK) Fail(database_, StepName(sqlite3_sql(statement_)));
}

bool Statement::Step() {
  const int result = sqlite3_step(statement_);
  if (result == SQLITE_ROW) return true;
  if (result != SQLITE_DONE) Fail(database_, StepName(sqlite3_sql(statement_)));
  return false;
}

void Statement::Run() {
  while (Step()) {
  }
  Check(sqlite3_reset(statement_));
}

std::string Statement::Text(int column) const {
  const void* const bytes = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  if (bytes == nullptr) return {};
  return std::string(static_cast<const char*>(bytes), static_cast<size_t>(size));
}

Statement& Statement::Bind(const Values& values) {
  int index = 0;
  for (const Value& value : values) Check(std::visit(Binding{statement_, ++index}, value));
  return *this;
}

Connection::Connection(const std::filesystem::path& file, Access access) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(file.c_str(), &database_, flags, nullptr) != SQLITE_OK) {
    const std::string reason = database_ == nullptr ? "out of memory" : sqlite3_errmsg(database_);
    sqlite3_close(database_);
    throw StorageError(std::string("open ").append(file.filename().string()), reason);
  }
  try {
    sqlite3_busy_timeout(database_, kBusyTimeoutMs);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    Execute("PRAGMA trusted_schema = OFF; PRAGMA foreign_keys = ON;");
    Execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;");
    if (access == Access::kRead) Execute("PRAGMA query_only = ON;");
  } catch (...) {
    sqlite3_close(database_);
    throw;
  }
}

Connection::~Connection() { sqlite3_close(database_); }

void Connection::Select(const std::string& sql, const Values& values, const Visit& visit) {
  Statement statement(database_, Translated(sql).c_str());
  statement.Bind(values);
  while (statement.Step() && visit(statement)) {
  }
}

int64_t Connection::Update(const std::string& sql, const Values& values) {
  Statement statement(database_, Translated(sql).c_str());
  statement.Bind(values).Run();
  return sqlite3_changes(database_);
}

void Connection::Execute(const std::string& sql) const {
  if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
    Fail(database_, StepName(sql));
  }
}

std::string Connection::FileName() const {
  return std::filesystem::path(sqlite3_db_filename(database_, "main")).filename().string();
}

void Connection::ReserveCommit() const {
  const int code = sqlite3_db_cacheflush(database_) & 0xff;
  if (code != SQLITE_OK && code != SQLITE_BUSY) {
    throw StorageError("write", sqlite3_errstr(code), FaultOf(database_, code));
  }
  // The commit appends the first page again, to which the connection holds.
  constexpr off_t kCommitBytes = 64 << 10;
  const char* const log = sqlite3_filename_wal(sqlite3_db_filename(database_, "main"));
  // SQLite has no POSIX lock on this file that closing it here could drop.
  const int file = ::open(log, O_WRONLY | O_CLOEXEC);
  struct stat status {};
  const bool is_reserved =
      file >= 0 && ::fstat(file, &status) == 0 &&
      ::fallocate(file, FALLOC_FL_KEEP_SIZE, status.st_size, kCommitBytes) == 0;
  const int error = is_reserved ? 0 : errno;
  if (file >= 0) ::close(file);
  // Other failures: the file system cannot reserve, or the commit itself tells.
  if (error == ENOSPC || error == EDQUOT) {
    throw StorageError("reserve room for a commit", std::strerror(error), StorageFault::kFull);
  }
}

Transaction::Transaction(Connection& connection) : connection_(connection) {
  connection_.Execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (!is_open_) return;
  try {
    connection_.Execute("ROLLBACK");
  } catch (const StorageError&) {
    // SQLite already rolled back by itself (disk full, I/O error).
    is_open_ = false;
  }
}

void Transaction::Commit() {
  connection_.Execute("COMMIT");
  is_open_ = false;
}

}  // namespace freelsd
