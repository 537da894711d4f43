#include "storage/postgres/pool.h"

#include <algorithm>
#include <thread>

namespace freelsd {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFirstPause{50};
constexpr std::chrono::milliseconds kLongestPause{1000};

std::chrono::milliseconds MillisecondsOf(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000.0));
}

}  // namespace

ConnectionPool::ConnectionPool(const StorageOptions& options)
    : url_(options.database_url),
      timeouts_{MillisecondsOf(options.connection_timeout_s),
                MillisecondsOf(options.statement_timeout_s)},
      max_num_connections_(options.max_num_connections) {}

std::unique_ptr<PostgresConnection> ConnectionPool::Take() {
  const auto deadline = SteadyClock::now() + timeouts_.connection;
  {
    std::unique_lock lock(mutex_);
    if (!AwaitFree(lock, deadline))
      throw StorageError("connect to the database", "all connections are in use");
    if (!idle_.empty()) {
      std::unique_ptr<PostgresConnection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
    ++num_open_;
  }
  try {
    return Connect(deadline);
  } catch (const StorageError&) {
    const std::lock_guard lock(mutex_);
    --num_open_;
    given_back_.notify_one();
    throw;
  }
}

bool ConnectionPool::AwaitFree(std::unique_lock<std::mutex>& lock,
                               SteadyClock::time_point deadline) {
  const auto is_free = [this] { return !idle_.empty() || num_open_ < max_num_connections_; };
  if (is_free()) return true;
  ++num_waits_;
  const auto begin = SteadyClock::now();
  const bool has_come = given_back_.wait_until(lock, deadline, is_free);
  waited_s_ += std::chrono::duration<double>(SteadyClock::now() - begin).count();
  return has_come;
}

PoolState ConnectionPool::State(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  PoolState state;
  state.name = name;
  state.num_open = num_open_;
  state.num_in_use = num_open_ - static_cast<int>(idle_.size());
  state.max_num_connections = max_num_connections_;
  state.num_waits = num_waits_;
  state.waited_s = waited_s_;
  return state;
}

std::unique_ptr<PostgresConnection> ConnectionPool::Connect(
    SteadyClock::time_point deadline) const {
  std::chrono::milliseconds pause = kFirstPause;
  for (;;) {
    try {
      return std::make_unique<PostgresConnection>(url_, timeouts_);
    } catch (const ConnectionLost& error) {
      if (SteadyClock::now() + pause > deadline) {
        throw StorageError("reach the database", error.what());
      }
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, kLongestPause);
  }
}

void ConnectionPool::GiveBack(std::unique_ptr<PostgresConnection> connection) {
  std::vector<std::unique_ptr<PostgresConnection>> closed;
  const std::lock_guard lock(mutex_);
  if (!connection->IsIdle()) {
    closed.swap(idle_);
    num_open_ -= static_cast<int>(closed.size()) + 1;
    given_back_.notify_all();
  } else {
    idle_.push_back(std::move(connection));
    given_back_.notify_one();
  }
}

// Nothing was done before BEGIN, so it may be sent twice.
PostgresTransaction::PostgresTransaction(ConnectionPool& pool)
    : lease_(std::make_unique<ConnectionLease>(pool)) {
  try {
    (*lease_)->Execute("BEGIN");
  } catch (const ConnectionLost&) {
    lease_.reset();
    lease_ = std::make_unique<ConnectionLease>(pool);
    (*lease_)->Execute("BEGIN");
  }
}

PostgresTransaction::~PostgresTransaction() {
  if (!is_open_) return;
  try {
    (*lease_)->Execute("ROLLBACK");
  } catch (const StorageError&) {
    // The connection is broken: the server rolls back, and the pool closes the connection.
    is_open_ = false;
  }
}

void PostgresTransaction::Commit() {
  (*lease_)->Execute("COMMIT");
  is_open_ = false;
}

}  // namespace freelsd
