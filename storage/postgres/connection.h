// RAII wrappers for libpq: connection and rows. All of them throw StorageError.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <libpq-fe.h>

#include "storage/postgres/parameters.h"
#include "storage/storage_error.h"

namespace freelsd {

// The connection broke, or the database did not answer in time. What it was doing may or may not
// have happened.
struct ConnectionLost : StorageError {
  using StorageError::StorageError;
};

// One row of a result; must not outlive it.
class PostgresRow final : public Row {
 public:
  PostgresRow(const PGresult* result, int row) : result_(result), row_(row) {}

  bool IsNull(int column) const override { return PQgetisnull(result_, row_, column) != 0; }
  int64_t Int(int column) const override { return IntegerIn(View(column)); }
  double Real(int column) const override { return RealIn(View(column)); }
  std::string Text(int column) const override { return std::string(View(column)); }

 private:
  std::string_view View(int column) const;

  const PGresult* result_;
  int row_;
};

class PostgresRows {
 public:
  explicit PostgresRows(PGresult* result) : result_(result, PQclear) {}

  int size() const { return PQntuples(result_.get()); }
  bool empty() const { return size() == 0; }
  PostgresRow operator[](int row) const { return {result_.get(), row}; }
  // Rows that an INSERT, UPDATE or DELETE changed.
  int64_t NumChanges() const;
  // Calls `make` with each row and collects the results.
  template <typename Make>
  auto Each(Make make) const {
    std::vector<decltype(make((*this)[0]))> all;
    all.reserve(static_cast<size_t>(size()));
    for (int row = 0; row < size(); ++row) all.push_back(make((*this)[row]));
    return all;
  }
  // Texts of the first column.
  std::vector<std::string> Texts() const;

 private:
  std::unique_ptr<PGresult, decltype(&PQclear)> result_;
};

struct PostgresTimeouts {
  std::chrono::milliseconds connection;
  std::chrono::milliseconds statement;
};

// Only one thread may use a connection at a time.
class PostgresConnection final : public Database {
 public:
  // Throws ConnectionLost if there is none within the time. It refuses servers that are read-only.
  PostgresConnection(const std::string& url, const PostgresTimeouts& timeouts);

  void Select(const std::string& sql, const Values& values, const Visit& visit) override;
  int64_t Update(const std::string& sql, const Values& values) override;
  bool HasChecksums() const override { return false; }
  // Prepares the statement once, binds $1, $2, ... in order and runs it.
  template <typename... Bound>
  PostgresRows Run(const std::string& sql, const Bound&... values) {
    return RunPrepared(sql, {ParameterOf(values)...});
  }
  // The same with any number of parameters.
  PostgresRows RunPrepared(const std::string& sql,
                           const std::vector<PostgresParameter>& parameters);
  // Runs several statements without parameters.
  void Execute(const std::string& sql);
  // After LISTEN: waits for a NOTIFY of another session. False if there was none in that time.
  bool AwaitNotification(std::chrono::milliseconds time);
  // False after ConnectionLost, and within a transaction.
  bool IsIdle() const {
    return !is_broken_ && PQtransactionStatus(connection_.get()) == PQTRANS_IDLE;
  }

 private:
  const std::string& Prepared(const std::string& sql,
                              const std::vector<PostgresParameter>& parameters);
  // Waits for all results of what was sent, and returns the last.
  PostgresRows Await(const std::string& step, int was_sent);
  PGresult* NextResult(const std::string& step, std::chrono::steady_clock::time_point deadline);
  void WaitForServer(const std::string& step, std::chrono::steady_clock::time_point deadline);
  [[noreturn]] void Lose(const std::string& step, const std::string& reason);

  std::unique_ptr<PGconn, decltype(&PQfinish)> connection_;
  PostgresTimeouts timeouts_;
  // Names of prepared statements, by their text.
  std::map<std::string, std::string> prepared_;
  bool is_broken_ = false;
};

// What a statement of PostgreSQL alone needs.
inline PostgresConnection& PostgresOf(Database& database) {
  return static_cast<PostgresConnection&>(database);
}

// Throws StorageError if the URI is none, or has a password: a command line is no place for it.
void CheckDatabaseUrl(const std::string& url);

}  // namespace freelsd
