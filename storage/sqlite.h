// SQLite in RAII: a connection, a statement that binds and reads by type, a transaction.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <sqlite3.h>

#include "storage/storage.h"

namespace freelsd {

// Bytes to bind as a blob rather than as text.
struct Blob {
  std::string_view bytes;
};

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
  // Whether there is a row. Throws StorageError.
  bool Step();
  // Runs to the end and resets.
  void Run();

  int64_t Int(int column) const { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  std::optional<double> OptionalReal(int column) const;
  std::optional<int64_t> OptionalInt(int column) const;
  std::string Text(int column) const;

 private:
  void BindOne(int index, int64_t value);
  void BindOne(int index, int value) { BindOne(index, static_cast<int64_t>(value)); }
  void BindOne(int index, double value);
  void BindOne(int index, const std::optional<double>& value);
  void BindOne(int index, const std::string& value);
  void BindOne(int index, const Blob& value);
  void Check(int result) const;

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

enum class Access { kWrite, kRead };

class Connection {
 public:
  Connection(const std::filesystem::path& file, Access access);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  Statement Prepare(const char* sql) const { return Statement(database_, sql); }
  // Several statements without parameters or rows.
  void Execute(const char* sql) const;
  // Makes what runs in another thread fail soon.
  void Interrupt() const { sqlite3_interrupt(database_); }
  int NumChanges() const { return sqlite3_changes(database_); }

 private:
  sqlite3* database_ = nullptr;
};

// Rolls back unless committed. On a write connection only.
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
