// RAII wrappers for SQLite: connection, statement, transaction. All of them throw StorageError.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <sqlite3.h>

#include "storage/database.h"

namespace freelsd {

// A prepared statement, and the row at which it stands. Must not outlive its connection.
class Statement final : public Row {
 public:
  Statement(sqlite3* database, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Binds ?1, ?2, ... in order.
  Statement& Bind(const Values& values);
  // Steps to the next row; false at the end.
  bool Step();
  // Steps to the end and resets.
  void Run();

  bool IsNull(int column) const override {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL;
  }
  int64_t Int(int column) const override { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const override { return sqlite3_column_double(statement_, column); }
  std::string Text(int column) const override;

 private:
  void Check(int result) const;

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

enum class Access { kWrite, kRead };

// A connection. Only one thread may use it at a time, except for Interrupt.
class Connection final : public Database {
 public:
  Connection(const std::filesystem::path& file, Access access);
  ~Connection() override;

  void Select(const std::string& sql, const Values& values, const Visit& visit) override;
  int64_t Update(const std::string& sql, const Values& values) override;
  bool HasChecksums() const override { return true; }
  // Runs several statements that have neither parameters nor rows.
  void Execute(const std::string& sql) const;
  // Aborts the statement that another thread is running on this connection. The statement then
  // fails soon.
  void Interrupt() const { sqlite3_interrupt(database_); }
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
  explicit Transaction(Connection& connection);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit();

 private:
  Connection& connection_;
  bool is_open_ = true;
};

}  // namespace freelsd
