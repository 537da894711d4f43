#include "storage/postgres/registration.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

// A flight that somebody is changing is left for the next time.
PostgresRows FlightWithoutWorker(PostgresConnection& writer) {
  return writer.Run(
      "SELECT id FROM flights WHERE (EXISTS (SELECT 1 FROM frames WHERE flight_id = flights.id AND "
      "state = 0) OR EXISTS (SELECT 1 FROM jobs WHERE flight_id = flights.id AND state < 2)) AND "
      "NOT EXISTS (SELECT 1 FROM claims WHERE flight_id = flights.id AND token IS NOT NULL) "
      "ORDER BY number LIMIT 1 FOR NO KEY UPDATE OF flights SKIP LOCKED");
}

SharedEvent EventOf(const PostgresRow& row) {
  return {row.Int(0), row.Text(1), row.Text(2), row.Text(3)};
}

constexpr std::chrono::milliseconds kLongestWait{250};

// A NOTIFY only wakes: what was told is in the table, also if the NOTIFY was lost.
void AwaitTold(PostgresState& state) {
  try {
    if (state.listener) {
      (*state.listener)->AwaitNotification(kLongestWait);
      return;
    }
    state.listener.emplace(state.listener_pool);
    (*state.listener)->Execute("LISTEN freelsd_told");
  } catch (const StorageError&) {
    state.listener.reset();
    throw;
  }
}

std::vector<SharedEvent> ReadTold(PostgresState& state, int64_t after_number, int limit) {
  return state.Read([&](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT number, type, flight_id, data FROM told_events WHERE number > $1 AND origin <> "
            "$2 ORDER BY number LIMIT $3",
            after_number,
            state.origin,
            limit)
        .Each(EventOf);
  });
}

}  // namespace

bool PostgresClaimStore::IsShared() const { return state_.options.is_shared; }

std::optional<Claim> PostgresClaimStore::ClaimNext() {
  if (!state_.registration) return std::nullopt;
  state_.registration->EndSessionsOfDead();
  PostgresWrite writer(state_);
  DropDeadWorkers(*writer, state_.registration->token());
  std::optional<Claim> claim;
  const PostgresRows flights = FlightWithoutWorker(*writer);
  if (!flights.empty()) {
    const std::string flight_id = flights[0].Text(0);
    // Another worker may have committed its claim since the flight was looked for.
    const PostgresRows rows = writer->Run(
        "INSERT INTO claims (flight_id, token) VALUES ($1, $2) ON CONFLICT (flight_id) DO UPDATE "
        "SET token = excluded.token WHERE claims.token IS NULL RETURNING num_lost",
        flight_id,
        state_.registration->token());
    if (!rows.empty()) claim = Claim{flight_id, rows[0].Int(0)};
  }
  writer.Commit();
  return claim;
}

std::vector<std::string> PostgresClaimStore::ListClaimed() const {
  if (!state_.registration) return {};
  return state_.Read([this](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT flight_id FROM claims JOIN flights ON flights.id = flight_id "
            "WHERE token = $1 ORDER BY number",
            state_.registration->token())
        .Texts();
  });
}

void PostgresClaimStore::Release(const std::string& flight_id) {
  if (!state_.registration) return;
  PostgresWrite writer(state_);
  writer->Run("DELETE FROM claims WHERE flight_id = $1 AND token = $2",
              flight_id,
              state_.registration->token());
  writer.Commit();
}

bool PostgresClaimStore::Renew() { return !state_.registration || state_.registration->Renew(); }

LeaseCounts PostgresClaimStore::CountLeases() const {
  return state_.Read([](PostgresConnection& connection) {
    const PostgresRows rows = connection.Run(
        "SELECT (SELECT count(*) FROM workers WHERE expires_at >= clock_timestamp()), "
        "(SELECT count(*) FROM workers WHERE expires_at < clock_timestamp()), "
        "(SELECT count(*) FROM claims WHERE token IS NOT NULL), "
        "(SELECT count(*) FROM (SELECT flight_id FROM frames WHERE state = 0 UNION SELECT "
        "flight_id FROM jobs WHERE state < 2) AS with_work WHERE NOT EXISTS (SELECT 1 FROM claims "
        "WHERE claims.flight_id = with_work.flight_id AND token IS NOT NULL))");
    return LeaseCounts{rows[0].Int(0), rows[0].Int(1), rows[0].Int(2), rows[0].Int(3)};
  });
}

void PostgresClaimStore::Tell(const SharedEvent& event) {
  if (!IsShared()) return;
  PostgresWrite writer(state_);
  writer->Execute("SET LOCAL synchronous_commit = off");
  writer->Run(
      "WITH next AS (UPDATE versions SET value = value + 1 WHERE name = 'events' RETURNING value) "
      "INSERT INTO told_events (number, origin, type, flight_id, data) SELECT value, $1, $2, $3, "
      "$4 FROM next",
      state_.origin,
      event.type,
      event.flight_id,
      event.data);
  writer->Execute("NOTIFY freelsd_told");
  writer.Commit();
}

std::vector<SharedEvent> PostgresClaimStore::ListTold(int64_t after_number, int limit) const {
  std::vector<SharedEvent> told = ReadTold(state_, after_number, limit);
  if (!told.empty()) return told;
  AwaitTold(state_);
  return ReadTold(state_, after_number, limit);
}

int64_t PostgresClaimStore::LastTold() const {
  return static_cast<int64_t>(state_.VersionOf("events"));
}

void PostgresClaimStore::ForgetOldTold() {
  PostgresWrite writer(state_);
  writer->Execute("DELETE FROM told_events WHERE told_at < now() - interval '10 minutes'");
  writer.Commit();
}

}  // namespace freelsd
