#include "storage/postgres/connection.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <poll.h>

namespace freelsd {
namespace {

using SteadyClock = std::chrono::steady_clock;

// The server ends a statement itself; the client gives up only if the server is silent.
constexpr std::chrono::milliseconds kSilence{2000};
// A transaction whose process stands still gives up its locks.
constexpr std::chrono::milliseconds kMaxIdleInTransaction{60000};

StorageFault FaultOf(std::string_view sql_state) {
  if (sql_state == "23505") return StorageFault::kConflict;
  if (sql_state == "53100") return StorageFault::kFull;
  if (sql_state == "XX001" || sql_state == "XX002") return StorageFault::kDamaged;
  return StorageFault::kOther;
}

// The beginning of the statement, for error messages; it contains no values.
std::string StepName(std::string_view sql) {
  return std::string(sql.substr(0, sql.find_first_of("(\n")));
}

std::string Milliseconds(std::chrono::milliseconds time) { return std::to_string(time.count()); }

// libpq takes whole seconds, at least 2.
std::string ConnectionSeconds(const PostgresTimeouts& timeouts) {
  return std::to_string(std::max<int64_t>(2, timeouts.connection.count() / 1000));
}

PGconn* Connect(const std::string& url, const PostgresTimeouts& timeouts) {
  const std::string seconds = ConnectionSeconds(timeouts);
  const std::string silence = Milliseconds(timeouts.statement + kSilence);
  // Later words overrule what the URI says.
  constexpr size_t kNumWords = 10;
  const std::array<const char*, kNumWords> words{"application_name",
                                                 "keepalives_idle",
                                                 "keepalives_interval",
                                                 "keepalives_count",
                                                 "dbname",
                                                 "connect_timeout",
                                                 "client_encoding",
                                                 "target_session_attrs",
                                                 "tcp_user_timeout",
                                                 nullptr};
  const std::array<const char*, kNumWords> values{"freelsd",
                                                  "5",
                                                  "5",
                                                  "3",
                                                  url.c_str(),
                                                  seconds.c_str(),
                                                  "UTF8",
                                                  "read-write",
                                                  silence.c_str(),
                                                  nullptr};
  return PQconnectdbParams(words.data(), values.data(), 1);
}

// libpq would print them, e.g. that the server shuts down; what matters comes as an error too.
void IgnoreNotice(void*, const char*) {}

// libpq ends its messages with line breaks.
std::string OneLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::vector<PostgresParameter> ParametersOf(const Values& values) {
  std::vector<PostgresParameter> parameters;
  parameters.reserve(values.size());
  for (const Value& value : values) parameters.push_back(ParameterOf(value));
  return parameters;
}

}  // namespace

std::string_view PostgresRow::View(int column) const {
  return {PQgetvalue(result_, row_, column),
          static_cast<size_t>(PQgetlength(result_, row_, column))};
}

int64_t PostgresRows::NumChanges() const {
  const std::string count = PQcmdTuples(result_.get());
  return count.empty() ? 0 : std::stoll(count);
}

std::vector<std::string> PostgresRows::Texts() const {
  return Each([](const PostgresRow& row) { return row.Text(0); });
}

PostgresConnection::PostgresConnection(const std::string& url, const PostgresTimeouts& timeouts)
    : connection_(Connect(url, timeouts), PQfinish), timeouts_(timeouts) {
  if (PQstatus(connection_.get()) != CONNECTION_OK) {
    Lose("connect to the database", OneLine(PQerrorMessage(connection_.get())));
  }
  PQsetNoticeProcessor(connection_.get(), IgnoreNotice, nullptr);
  PQsetnonblocking(connection_.get(), 1);
  Execute(
      // A plan is compiled for longer than any of these statements runs.
      "SET jit = off; SET synchronous_commit = on; SET client_min_messages = warning; "
      "SET statement_timeout = " +
      Milliseconds(timeouts_.statement) +
      "; SET idle_in_transaction_session_timeout = " + Milliseconds(kMaxIdleInTransaction));
}

void PostgresConnection::Lose(const std::string& step, const std::string& reason) {
  is_broken_ = true;
  throw ConnectionLost(step, reason);
}

void PostgresConnection::WaitForServer(const std::string& step, SteadyClock::time_point deadline) {
  const bool is_all_sent = PQflush(connection_.get()) == 0;
  pollfd waiting{
      PQsocket(connection_.get()), static_cast<short>(is_all_sent ? POLLIN : POLLIN | POLLOUT), 0};
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline - SteadyClock::now());
  if (left.count() <= 0) Lose(step, "the database does not answer");
  if (::poll(&waiting, 1, static_cast<int>(left.count()) + 1) < 0 && errno != EINTR) {
    Lose(step, "the connection to the database failed");
  }
  if (PQconsumeInput(connection_.get()) == 0) {
    Lose(step, OneLine(PQerrorMessage(connection_.get())));
  }
}

PGresult* PostgresConnection::NextResult(const std::string& step,
                                         SteadyClock::time_point deadline) {
  while (PQflush(connection_.get()) != 0 || PQisBusy(connection_.get()) != 0) {
    WaitForServer(step, deadline);
  }
  return PQgetResult(connection_.get());
}

PostgresRows PostgresConnection::Await(const std::string& step, int was_sent) {
  if (was_sent == 0) Lose(step, OneLine(PQerrorMessage(connection_.get())));
  const auto deadline = SteadyClock::now() + timeouts_.statement + kSilence;
  PostgresRows last(nullptr);
  std::optional<StorageError> error;
  while (PGresult* const result = NextResult(step, deadline)) {
    last = PostgresRows(result);
    const ExecStatusType status = PQresultStatus(result);
    if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK || error) continue;
    const char* const state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
    const char* const message = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
    error.emplace(step,
                  message == nullptr ? OneLine(PQerrorMessage(connection_.get())) : message,
                  FaultOf(state == nullptr ? "" : state));
  }
  if (PQstatus(connection_.get()) != CONNECTION_OK) {
    Lose(step, error ? error->what() : "the connection to the database was lost");
  }
  if (error) throw StorageError(*error);
  return last;
}

void PostgresConnection::Execute(const std::string& sql) {
  Await(StepName(sql), PQsendQuery(connection_.get(), sql.c_str()));
}

bool PostgresConnection::AwaitNotification(std::chrono::milliseconds time) {
  const std::string step = "wait for news";
  const auto deadline = SteadyClock::now() + time;
  for (bool is_over = false;;) {
    bool has_come = false;
    while (PGnotify* const notification = PQnotifies(connection_.get())) {
      PQfreemem(notification);
      has_come = true;
    }
    if (has_come || is_over) return has_come;
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - SteadyClock::now());
    is_over = left.count() <= 0;
    pollfd waiting{PQsocket(connection_.get()), POLLIN, 0};
    const int timeout_ms = is_over ? 0 : static_cast<int>(left.count()) + 1;
    if (::poll(&waiting, 1, timeout_ms) < 0 && errno != EINTR) {
      Lose(step, "the connection to the database failed");
    }
    if (waiting.revents != 0 && PQconsumeInput(connection_.get()) == 0) {
      Lose(step, OneLine(PQerrorMessage(connection_.get())));
    }
  }
}

const std::string& PostgresConnection::Prepared(const std::string& sql,
                                                const std::vector<PostgresParameter>& parameters) {
  if (const auto found = prepared_.find(sql); found != prepared_.end()) {
    return found->second;
  }
  std::vector<Oid> types;
  types.reserve(parameters.size());
  for (const PostgresParameter& parameter : parameters) types.push_back(parameter.type);
  const std::string name = "statement_" + std::to_string(prepared_.size());
  Await(StepName(sql),
        PQsendPrepare(connection_.get(),
                      name.c_str(),
                      sql.c_str(),
                      static_cast<int>(types.size()),
                      types.data()));
  return prepared_.emplace(sql, name).first->second;
}

void PostgresConnection::Select(const std::string& sql, const Values& values, const Visit& visit) {
  const PostgresRows rows = RunPrepared(sql, ParametersOf(values));
  for (int row = 0; row < rows.size() && visit(rows[row]); ++row) {
  }
}

int64_t PostgresConnection::Update(const std::string& sql, const Values& values) {
  return RunPrepared(sql, ParametersOf(values)).NumChanges();
}

PostgresRows PostgresConnection::RunPrepared(const std::string& sql,
                                             const std::vector<PostgresParameter>& parameters) {
  const std::string& name = Prepared(sql, parameters);
  std::vector<const char*> values;
  std::vector<int> lengths;
  for (const PostgresParameter& parameter : parameters) {
    values.push_back(parameter.bytes ? parameter.bytes->data() : nullptr);
    lengths.push_back(parameter.bytes ? static_cast<int>(parameter.bytes->size()) : 0);
  }
  const std::vector<int> formats(parameters.size(), 1);
  return Await(StepName(sql),
               PQsendQueryPrepared(connection_.get(),
                                   name.c_str(),
                                   static_cast<int>(parameters.size()),
                                   values.data(),
                                   lengths.data(),
                                   formats.data(),
                                   1));
}

void CheckDatabaseUrl(const std::string& url) {
  char* error = nullptr;
  PQconninfoOption* const options = PQconninfoParse(url.c_str(), &error);
  if (options == nullptr) {
    const std::string reason = OneLine(error == nullptr ? "out of memory" : error);
    PQfreemem(error);
    throw StorageError("read the database's URI", reason);
  }
  bool has_password = false;
  for (const PQconninfoOption* option = options; option->keyword != nullptr; ++option) {
    has_password =
        has_password || (std::string_view(option->keyword) == "password" && option->val != nullptr);
  }
  PQconninfoFree(options);
  if (!has_password) return;
  throw StorageError("read the database's URI",
                     "it has a password, which others can read on the command line; put the "
                     "password into the file that PGPASSFILE names");
}

}  // namespace freelsd
