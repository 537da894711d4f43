#include <algorithm>

#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectChanges[] =
    "SELECT subject, id, number, kind, changed_at_us, stamp_us, origin FROM changes ";

ChangeRow ChangeRowOf(const PostgresRow& row) {
  ChangeRow change;
  change.key = {static_cast<ChangeSubject>(row.Int(0)), row.Text(1)};
  change.number = row.Int(2);
  change.kind = static_cast<ChangeKind>(row.Int(3));
  change.changed_at_us = row.Int(4);
  change.stamp_us = row.Int(5);
  change.origin = row.Text(6);
  return change;
}

int64_t SubjectOf(const ChangeKey& key) { return static_cast<int64_t>(key.subject); }

// Holds the row that orders the numbers.
void LockNumbers(PostgresConnection& writer) {
  writer.Run("SELECT 1 FROM versions WHERE name = 'sites' FOR NO KEY UPDATE");
}

// West > east crosses the antimeridian.
std::string MeetsBox(int first) {
  const auto place = [first](int i) { return "$" + std::to_string(first + i); };
  return "south_deg <= " + place(3) + " AND north_deg >= " + place(1) + " AND CASE WHEN " +
         place(0) + " <= " + place(2) + " THEN west_deg <= " + place(2) +
         " AND east_deg >= " + place(0) + " ELSE west_deg <= " + place(2) +
         " OR east_deg >= " + place(0) + " END";
}

PostgresRows RowsAfter(PostgresConnection& connection,
                       int64_t after_number,
                       size_t limit,
                       const std::optional<ChangeArea>& area) {
  const ChangeArea given = area.value_or(ChangeArea{});
  return connection.Run(std::string(kSelectChanges) +
                            "WHERE number > $1 AND (NOT $2 OR (subject = 0 AND " + MeetsBox(4) +
                            ") OR (subject <> 0 AND " + MeetsBox(8) + ")) ORDER BY number LIMIT $3",
                        after_number,
                        area.has_value(),
                        static_cast<int64_t>(limit),
                        given.sites.west_deg,
                        given.sites.south_deg,
                        given.sites.east_deg,
                        given.sites.north_deg,
                        given.surroundings.west_deg,
                        given.surroundings.south_deg,
                        given.surroundings.east_deg,
                        given.surroundings.north_deg);
}

int64_t HighestNumber(PostgresConnection& connection) {
  return connection
      .Run(
          "SELECT greatest((SELECT max(number) FROM changes), (SELECT forgotten_through FROM "
          "feed))")[0]
      .Int(0);
}

[[noreturn]] void RefuseToFollow() {
  throw StorageError("follow a server", "only a server on SQLite follows another one");
}

}  // namespace

std::string PostgresChangeStore::FeedId() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT id FROM feed")[0].Text(0);
  });
}

int64_t PostgresChangeStore::LastNumber() const { return state_.Read(HighestNumber); }

int64_t PostgresChangeStore::ForgottenThrough() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT forgotten_through FROM feed")[0].Int(0);
  });
}

ChangePage PostgresChangeStore::List(int64_t after_number,
                                     size_t limit,
                                     const std::optional<ChangeArea>& area) const {
  return state_.Read([&](PostgresConnection& connection) {
    ChangePage page;
    // Read first: a later change is for the next page.
    page.last_number = HighestNumber(connection);
    page.changes = RowsAfter(connection, after_number, limit + 1, area).Each(ChangeRowOf);
    page.has_more = page.changes.size() > limit;
    if (page.has_more) {
      page.changes.pop_back();
      page.last_number = page.changes.back().number;
    } else if (!page.changes.empty()) {
      page.last_number = std::max(page.last_number, page.changes.back().number);
    }
    return page;
  });
}

std::optional<ChangeRow> PostgresChangeStore::Find(const ChangeKey& key) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<ChangeRow> {
    const PostgresRows rows = connection.Run(
        std::string(kSelectChanges) + "WHERE subject = $1 AND id = $2", SubjectOf(key), key.id);
    if (rows.empty()) return std::nullopt;
    return ChangeRowOf(rows[0]);
  });
}

void PostgresChangeStore::Repeat(const std::vector<ChangeKey>& keys) {
  PostgresWrite writer(state_);
  LockNumbers(*writer);
  for (const ChangeKey& key : keys) {
    writer->Run(
        "UPDATE changes SET number = nextval('change_numbers') WHERE subject = $1 AND id = $2",
        SubjectOf(key),
        key.id);
  }
  writer.Commit();
}

void PostgresChangeStore::SetOrigins(const std::vector<ChangeRow>& changes) {
  PostgresWrite writer(state_);
  LockNumbers(*writer);
  for (const ChangeRow& change : changes) {
    writer->Run(
        "UPDATE changes SET number = nextval('change_numbers'), origin = named.origin FROM (SELECT "
        "CASE WHEN $3 = id THEN '' ELSE $3 END AS origin FROM feed) AS named "
        "WHERE subject = $1 AND changes.id = $2 AND changes.origin <> named.origin",
        SubjectOf(change.key),
        change.key.id,
        change.origin);
  }
  writer.Commit();
}

void PostgresChangeStore::PutRemoval(const ChangeRow& removal) {
  PostgresWrite writer(state_);
  LockNumbers(*writer);
  writer->Run(
      "INSERT INTO changes AS known (subject, id, number, kind, changed_at_us, stamp_us, west_deg, "
      "south_deg, east_deg, north_deg, origin) VALUES ($1, $2, nextval('change_numbers'), $3, $4, "
      "$5, -180, -90, 180, 90, $6) ON CONFLICT (subject, id) DO UPDATE SET number = "
      "excluded.number, stamp_us = excluded.stamp_us, changed_at_us = excluded.changed_at_us "
      "WHERE known.kind >= 4 AND known.stamp_us < excluded.stamp_us",
      SubjectOf(removal.key),
      removal.key.id,
      static_cast<int64_t>(removal.kind),
      removal.changed_at_us,
      removal.stamp_us,
      removal.origin);
  writer.Commit();
}

void PostgresChangeStore::ForgetRemoved(int64_t before_us) {
  PostgresWrite writer(state_);
  LockNumbers(*writer);
  writer->Run(
      "UPDATE feed SET forgotten_through = greatest(forgotten_through, (SELECT "
      "coalesce(max(number), 0) FROM changes WHERE kind >= 4 AND changed_at_us < $1))",
      before_us);
  writer->Run("DELETE FROM changes WHERE kind >= 4 AND changed_at_us < $1", before_us);
  writer.Commit();
}

std::vector<ChangeRow> PostgresChangeStore::ListUnknownAbove(size_t /*limit*/) const { return {}; }

void PostgresChangeStore::SetKnownAbove(const std::vector<ChangeRow>& /*changes*/) {
  RefuseToFollow();
}

void PostgresChangeStore::SetUnknownAbove(const std::vector<ChangeKey>& /*keys*/) {
  RefuseToFollow();
}

void PostgresChangeStore::SetAllUnknownAbove(const std::string& /*except_origin*/) {
  RefuseToFollow();
}

std::optional<FollowState> PostgresChangeStore::FindFollowState() const { return std::nullopt; }

void PostgresChangeStore::PutFollowState(const FollowState& /*state*/) { RefuseToFollow(); }

}  // namespace freelsd
