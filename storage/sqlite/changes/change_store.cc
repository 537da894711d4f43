#include <algorithm>

#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectChanges[] =
    "SELECT subject, id, number, kind, changed_at_us, stamp_us, origin, is_known_above "
    "FROM changes ";

ChangeRow ChangeRowOf(const Statement& statement) {
  ChangeRow change;
  change.key = {static_cast<ChangeSubject>(statement.Int(0)), statement.Text(1)};
  change.number = statement.Int(2);
  change.kind = static_cast<ChangeKind>(statement.Int(3));
  change.changed_at_us = statement.Int(4);
  change.stamp_us = statement.Int(5);
  change.origin = statement.Text(6);
  change.is_known_above = statement.Int(7) != 0;
  return change;
}

int SubjectOf(const ChangeKey& key) { return static_cast<int>(key.subject); }

int64_t NumberOf(const Connection& connection, const char* sql) {
  Statement statement = connection.Prepare(sql);
  statement.Step();
  return statement.Int(0);
}

// West > east crosses the antimeridian.
std::string MeetsBox(int first) {
  const auto place = [first](int i) { return "?" + std::to_string(first + i); };
  return "south_deg <= " + place(3) + " AND north_deg >= " + place(1) + " AND CASE WHEN " +
         place(0) + " <= " + place(2) + " THEN west_deg <= " + place(2) +
         " AND east_deg >= " + place(0) + " ELSE west_deg <= " + place(2) +
         " OR east_deg >= " + place(0) + " END";
}

std::vector<ChangeRow> RowsAfter(const Connection& connection,
                                 int64_t after_number,
                                 size_t limit,
                                 const std::optional<ChangeArea>& area) {
  const std::string sql = std::string(kSelectChanges) +
                          "WHERE number > ?1 AND (?2 = 0 OR (subject = 0 AND " + MeetsBox(4) +
                          ") OR (subject <> 0 AND " + MeetsBox(8) + ")) ORDER BY number LIMIT ?3";
  Statement statement = connection.Prepare(sql.c_str());
  const ChangeArea given = area.value_or(ChangeArea{});
  statement.Bind(after_number,
                 static_cast<int>(area.has_value()),
                 static_cast<int64_t>(limit),
                 given.sites.west_deg,
                 given.sites.south_deg,
                 given.sites.east_deg,
                 given.sites.north_deg,
                 given.surroundings.west_deg,
                 given.surroundings.south_deg,
                 given.surroundings.east_deg,
                 given.surroundings.north_deg);
  std::vector<ChangeRow> changes;
  while (statement.Step()) changes.push_back(ChangeRowOf(statement));
  return changes;
}

// Runs `change` with the writer of the main database, in a transaction.
template <typename Change>
void WriteMain(StorageState& state, const Change& change) {
  const auto lock = state.LockForWriting();
  Transaction transaction(state.writer);
  change(state.writer);
  transaction.Commit();
}

}  // namespace

std::string SqliteChangeStore::FeedId() const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare("SELECT id FROM feed");
  statement.Step();
  return statement.Text(0);
}

int64_t SqliteChangeStore::LastNumber() const {
  const Reader reader(state_.readers);
  return NumberOf(*reader, "SELECT number FROM feed");
}

int64_t SqliteChangeStore::ForgottenThrough() const {
  const Reader reader(state_.readers);
  return NumberOf(*reader, "SELECT forgotten_through FROM feed");
}

ChangePage SqliteChangeStore::List(int64_t after_number,
                                   size_t limit,
                                   const std::optional<ChangeArea>& area) const {
  const Reader reader(state_.readers);
  ChangePage page;
  // Read first: a later change is for the next page.
  page.last_number = NumberOf(*reader, "SELECT number FROM feed");
  page.changes = RowsAfter(*reader, after_number, limit + 1, area);
  page.has_more = page.changes.size() > limit;
  if (page.has_more) {
    page.changes.pop_back();
    page.last_number = page.changes.back().number;
  } else if (!page.changes.empty()) {
    page.last_number = std::max(page.last_number, page.changes.back().number);
  }
  return page;
}

std::optional<ChangeRow> SqliteChangeStore::Find(const ChangeKey& key) const {
  const Reader reader(state_.readers);
  Statement statement =
      reader->Prepare((std::string(kSelectChanges) + "WHERE subject = ?1 AND id = ?2").c_str());
  if (!statement.Bind(SubjectOf(key), key.id).Step()) return std::nullopt;
  return ChangeRowOf(statement);
}

void SqliteChangeStore::Repeat(const std::vector<ChangeKey>& keys) {
  WriteMain(state_, [&](const Connection& writer) {
    for (const ChangeKey& key : keys) {
      writer.Execute("UPDATE feed SET number = number + 1");
      writer
          .Prepare(
              "UPDATE changes SET number = (SELECT number FROM feed) WHERE subject = ?1 AND id = "
              "?2")
          .Bind(SubjectOf(key), key.id)
          .Run();
    }
  });
}

void SqliteChangeStore::SetOrigins(const std::vector<ChangeRow>& changes) {
  WriteMain(state_, [&](const Connection& writer) {
    for (const ChangeRow& change : changes) {
      writer.Execute("UPDATE feed SET number = number + 1");
      writer
          .Prepare(
              "UPDATE changes SET number = (SELECT number FROM feed), "
              "origin = iif(?3 = (SELECT id FROM feed), '', ?3) WHERE subject = ?1 AND id = ?2 "
              "AND origin <> iif(?3 = (SELECT id FROM feed), '', ?3)")
          .Bind(SubjectOf(change.key), change.key.id, change.origin)
          .Run();
    }
  });
}

void SqliteChangeStore::PutRemoval(const ChangeRow& removal) {
  WriteMain(state_, [&](const Connection& writer) {
    writer.Execute("UPDATE feed SET number = number + 1");
    writer
        .Prepare(
            "INSERT INTO changes SELECT ?1, ?2, number, ?3, ?4, ?5, -180, -90, 180, 90, ?6, ?7 "
            "FROM feed WHERE true ON CONFLICT (subject, id) DO UPDATE SET number = "
            "excluded.number, stamp_us = excluded.stamp_us, changed_at_us = "
            "excluded.changed_at_us WHERE kind >= 4 AND stamp_us < excluded.stamp_us")
        .Bind(SubjectOf(removal.key),
              removal.key.id,
              static_cast<int>(removal.kind),
              removal.changed_at_us,
              removal.stamp_us,
              removal.origin,
              static_cast<int>(removal.is_known_above))
        .Run();
  });
}

void SqliteChangeStore::ForgetRemoved(int64_t before_us) {
  WriteMain(state_, [&](const Connection& writer) {
    writer
        .Prepare(
            "UPDATE feed SET forgotten_through = max(forgotten_through, (SELECT "
            "coalesce(max(number), 0) FROM changes WHERE kind >= 4 AND changed_at_us < ?1))")
        .Bind(before_us)
        .Run();
    writer.Prepare("DELETE FROM changes WHERE kind >= 4 AND changed_at_us < ?1")
        .Bind(before_us)
        .Run();
  });
}

std::vector<ChangeRow> SqliteChangeStore::ListUnknownAbove(size_t limit) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(
      (std::string(kSelectChanges) + "WHERE is_known_above = 0 ORDER BY number LIMIT ?1").c_str());
  statement.Bind(static_cast<int64_t>(limit));
  std::vector<ChangeRow> changes;
  while (statement.Step()) changes.push_back(ChangeRowOf(statement));
  return changes;
}

void SqliteChangeStore::SetKnownAbove(const std::vector<ChangeRow>& changes) {
  WriteMain(state_, [&](const Connection& writer) {
    for (const ChangeRow& change : changes) {
      writer
          .Prepare(
              "UPDATE changes SET is_known_above = 1 WHERE subject = ?1 AND id = ?2 AND number = "
              "?3")
          .Bind(SubjectOf(change.key), change.key.id, change.number)
          .Run();
    }
  });
}

void SqliteChangeStore::SetUnknownAbove(const std::vector<ChangeKey>& keys) {
  WriteMain(state_, [&](const Connection& writer) {
    for (const ChangeKey& key : keys) {
      writer.Prepare("UPDATE changes SET is_known_above = 0 WHERE subject = ?1 AND id = ?2")
          .Bind(SubjectOf(key), key.id)
          .Run();
    }
  });
}

void SqliteChangeStore::SetAllUnknownAbove(const std::string& except_origin) {
  WriteMain(state_, [&](const Connection& writer) {
    // What the former server had withdrawn is nobody's wish to remove it from another one.
    writer.Prepare("UPDATE changes SET is_known_above = 0 WHERE origin <> ?1 AND kind < 4")
        .Bind(except_origin)
        .Run();
  });
}

std::optional<FollowState> SqliteChangeStore::FindFollowState() const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare("SELECT followed, next, in_step_at_us FROM follow_state");
  if (!statement.Step()) return std::nullopt;
  return FollowState{statement.Text(0), statement.Text(1), statement.OptionalInt(2)};
}

void SqliteChangeStore::PutFollowState(const FollowState& state) {
  WriteMain(state_, [&](const Connection& writer) {
    writer.Execute("DELETE FROM follow_state");
    writer.Prepare("INSERT INTO follow_state VALUES (?1, ?2, nullif(?3, 0))")
        .Bind(state.followed, state.next, state.in_step_at_us.value_or(0))
        .Run();
  });
}

}  // namespace freelsd
