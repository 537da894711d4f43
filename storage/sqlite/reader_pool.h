// A pool of read connections. It grows to the number of connections in use at the same time.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "storage/sqlite/sqlite.h"

namespace freelsd {

// Thread-safe.
class ReaderPool {
 public:
  explicit ReaderPool(const std::filesystem::path& database_file) : file_(database_file) {}
  std::unique_ptr<Connection> Take();
  void GiveBack(std::unique_ptr<Connection> connection);

 private:
  std::filesystem::path file_;
  // Guards idle_.
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;
};

// Holds a connection of the pool during its lifetime.
class Reader {
 public:
  explicit Reader(ReaderPool& pool) : pool_(pool), connection_(pool.Take()) {}
  ~Reader() { pool_.GiveBack(std::move(connection_)); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  Connection* operator->() const { return connection_.get(); }
  Connection& operator*() const { return *connection_; }

 private:
  ReaderPool& pool_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace freelsd
