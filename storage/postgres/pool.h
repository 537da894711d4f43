// A pool of connections to PostgreSQL.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "storage/postgres/connection.h"
#include "storage/storage.h"

namespace freelsd {

// It grows to the number of connections in use at the same time, at most max_num_connections.
// Thread-safe.
class ConnectionPool {
 public:
  explicit ConnectionPool(const StorageOptions& options);

  // Waits for a connection, and tries again with growing pauses if the database cannot be reached.
  // Throws StorageError when connection_timeout_s is over.
  std::unique_ptr<PostgresConnection> Take();
  // A broken connection is closed, and those that are idle with it: the database was restarted.
  void GiveBack(std::unique_ptr<PostgresConnection> connection);
  PoolState State(const std::string& name) const;

 private:
  // Within the lock. False if none is free at the deadline.
  bool AwaitFree(std::unique_lock<std::mutex>& lock,
                 std::chrono::steady_clock::time_point deadline);
  std::unique_ptr<PostgresConnection> Connect(std::chrono::steady_clock::time_point deadline) const;

  std::string url_;
  PostgresTimeouts timeouts_;
  int max_num_connections_;
  // Guards the fields below.
  mutable std::mutex mutex_;
  std::condition_variable given_back_;
  int num_open_ = 0;
  int64_t num_waits_ = 0;
  double waited_s_ = 0.0;
  std::vector<std::unique_ptr<PostgresConnection>> idle_;
};

// Holds a connection of the pool during its lifetime.
class ConnectionLease {
 public:
  explicit ConnectionLease(ConnectionPool& pool) : pool_(pool), connection_(pool.Take()) {}
  ~ConnectionLease() { pool_.GiveBack(std::move(connection_)); }
  ConnectionLease(const ConnectionLease&) = delete;
  ConnectionLease& operator=(const ConnectionLease&) = delete;
  PostgresConnection& operator*() const { return *connection_; }
  PostgresConnection* operator->() const { return connection_.get(); }

 private:
  ConnectionPool& pool_;
  std::unique_ptr<PostgresConnection> connection_;
};

// Runs `act` with a connection, once more with a new one if the connection breaks. Only for what
// may run twice.
template <typename Act>
auto WithConnection(ConnectionPool& pool, const Act& act) {
  try {
    const ConnectionLease lease(pool);
    return act(*lease);
  } catch (const ConnectionLost&) {
    const ConnectionLease lease(pool);
    return act(*lease);
  }
}

// A transaction (READ COMMITTED). Rolls back unless Commit was called.
class PostgresTransaction {
 public:
  explicit PostgresTransaction(ConnectionPool& pool);
  ~PostgresTransaction();
  PostgresTransaction(const PostgresTransaction&) = delete;
  PostgresTransaction& operator=(const PostgresTransaction&) = delete;
  PostgresConnection& operator*() const { return **lease_; }
  PostgresConnection* operator->() const { return &**lease_; }
  // If the connection breaks meanwhile, throws ConnectionLost, and the data may be stored or not.
  void Commit();

 private:
  std::unique_ptr<ConnectionLease> lease_;
  bool is_open_ = true;
};

}  // namespace freelsd
