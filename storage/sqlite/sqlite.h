// RAII wrappers for SQLite: connection, statement, transaction. All of them throw StorageError.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <sqlite3.h>

namespace freelsd {

// Bytes that are bound as a blob, not as text.
struct Blob {
  std::string_view bytes;
};

// A prepared statement. Columns count from 0. Must not outlive its connection.
class Statement {
 public:
  Statement(sqlite3* database, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Binds ?1, ?2, ... in order.
  template <typename... Values>
  Statement& Bind(const Values&... values) {
    int index = 0;
    (BindOne(++index, values), ...);
    return *this;
  }
  // Binds ?index. What is bound must live until Run or the last Step.
  void BindOne(int index, int64_t value);
  void BindOne(int index, int value) { BindOne(index, static_cast<int64_t>(value)); }
  void BindOne(int index, double value);
  void BindOne(int index, const std::optional<double>& value);
  void BindOne(int index, const std::string& value);
  void BindOne(int index, const Blob& value);
  // Steps to the next row; false at the end.
  bool Step();
  // Steps to the end and resets.
  void Run();

  int64_t Int(int column) const { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  std::optional<double> OptionalReal(int column) const;
  std::optional<int64_t> OptionalInt(int column) const;
  std::string Text(int column) const;

 private:
  void Check(int result) const;

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

enum class Access { kWrite, kRead };

// A connection. Only one thread may use it at a time, except for Interrupt.
class Connection {
 public:
  Connection(const std::filesystem::path& file, Access access);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  Statement Prepare(const char* sql) const { return Statement(database_, sql); }
  // Runs several statements that have neither parameters nor rows.
  void Execute(const char* sql) const;
  // Aborts the statement that another thread is running on this connection. The statement then
  // fails soon.
  void Interrupt() const { sqlite3_interrupt(database_); }
  int NumChanges() const { return sqlite3_changes(database_); }
  std::string FileName() const;
  // Writes what the open transaction has changed to the disk, and reserves the room that its commit
  // needs. After that, a full disk cannot refuse the commit.
  void ReserveCommit() const;

 private:
  sqlite3* database_ = nullptr;
};

// A transaction on a write connection. Rolls back unless Commit was called.
class Transaction {
 public:
  explicit Transaction(const Connection& connection);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit();

 private:
  const Connection& connection_;
  bool is_open_ = true;
};

}  // namespace freelsd
