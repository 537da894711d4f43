#include "storage/postgres/registration.h"

#include <vector>

namespace freelsd {
namespace {

// The name of a worker's session while a transaction of it goes on.
constexpr char kSessionName[] = "'freelsd worker ' || current_schema() || ' ' || token";

int64_t Register(ConnectionPool& pool, double lease_s) {
  return WithConnection(pool, [lease_s](PostgresConnection& connection) {
    return connection
        .Run(
            "INSERT INTO workers (expires_at) VALUES (clock_timestamp() + make_interval(secs => "
            "$1)) RETURNING token",
            lease_s)[0]
        .Int(0);
  });
}

}  // namespace

Registration::Registration(ConnectionPool& pool, double lease_s)
    : pool_(pool), lease_s_(lease_s), token_(Register(pool, lease_s)) {}

Registration::~Registration() {
  try {
    PostgresTransaction writer(pool_);
    writer->Run("UPDATE claims SET token = NULL, num_lost = 0 WHERE token = $1", token_);
    writer->Run("DELETE FROM workers WHERE token = $1", token_);
    writer.Commit();
  } catch (const StorageError&) {
    // The lease ends by itself.
    return;
  }
}

void Registration::Check(PostgresConnection& writer) const {
  const PostgresRows rows =
      writer.Run(std::string("SELECT set_config('application_name', ") + kSessionName +
                     ", true) FROM workers WHERE token = $1 FOR KEY SHARE",
                 token_);
  if (rows.empty()) throw StorageError("write", "this worker's lease was over");
}

bool Registration::Renew() {
  return WithConnection(pool_, [this](PostgresConnection& connection) {
    return connection
               .Run(
                   "UPDATE workers SET expires_at = clock_timestamp() + make_interval(secs => $2) "
                   "WHERE token = $1",
                   token_,
                   lease_s_)
               .NumChanges() > 0;
  });
}

// As the user of the URI, who may end sessions of the same user.
void Registration::EndSessionsOfDead() {
  WithConnection(pool_, [this](PostgresConnection& connection) {
    connection.Run(std::string("SELECT pg_terminate_backend(pid) FROM workers JOIN "
                               "pg_stat_activity ON application_name = ") +
                       kSessionName +
                       " WHERE expires_at < clock_timestamp() AND token <> $1 AND datname = "
                       "current_database()",
                   token_);
  });
}

void DropDeadWorkers(PostgresConnection& writer, int64_t own_token) {
  const std::vector<int64_t> dead =
      writer
          .Run(
              "SELECT token FROM workers WHERE expires_at < clock_timestamp() AND token <> $1 "
              "FOR UPDATE SKIP LOCKED",
              own_token)
          .Each([](const PostgresRow& row) { return row.Int(0); });
  for (const int64_t token : dead) {
    writer.Run("UPDATE claims SET token = NULL, num_lost = num_lost + 1 WHERE token = $1", token);
    writer.Run("DELETE FROM workers WHERE token = $1", token);
  }
}

}  // namespace freelsd
