#include <algorithm>

#include "storage/stores/stores.h"

namespace freelsd {
namespace {

ChangeRow ChangeRowOf(const Row& row) {
  ChangeRow change;
  change.key = {static_cast<ChangeSubject>(row.Int(0)), row.Text(1)};
  change.number = row.Int(2);
  change.kind = static_cast<ChangeKind>(row.Int(3));
  change.changed_at_us = row.Int(4);
  change.stamp_us = row.Int(5);
  change.origin = row.Text(6);
  change.is_known_above = row.Bool(7);
  return change;
}

int SubjectOf(const ChangeKey& key) { return static_cast<int>(key.subject); }

// West > east crosses the antimeridian.
std::string MeetsBox(int first) {
  const auto place = [first](int i) { return "$" + std::to_string(first + i); };
  return "south_deg <= " + place(3) + " AND north_deg >= " + place(1) + " AND CASE WHEN " +
         place(0) + " <= " + place(2) + " THEN west_deg <= " + place(2) +
         " AND east_deg >= " + place(0) + " ELSE west_deg <= " + place(2) +
         " OR east_deg >= " + place(0) + " END";
}

// All numbers that `change` gives are higher than those that others gave.
template <typename Change>
void WriteChanges(StoreAccess& access, const Change& change) {
  access.Write([&](Writer& writer) {
    const std::string& lock = access.dialect().lock_changes;
    if (!lock.empty()) writer->Has(lock);
    change(*writer);
  });
}

void StepNumber(Database& writer, const Dialect& dialect) {
  if (!dialect.step_change.empty()) writer.Change(dialect.step_change);
}

}  // namespace

void SqlChangeStore::CheckThatItFollows() const {
  if (access_.dialect().can_follow) return;
  throw StorageError("follow a server", "only a server on SQLite follows another one");
}

std::string SqlChangeStore::SelectChanges() const {
  return std::string("SELECT subject, id, number, kind, changed_at_us, stamp_us, origin, ") +
         (access_.dialect().can_follow ? "is_known_above" : "false") + " FROM changes ";
}

std::string SqlChangeStore::FeedId() const {
  return access_.Read([](Database& database) {
    return database.First([](const Row& row) { return row.Text(0); }, "SELECT id FROM feed")
        .value_or("");
  });
}

int64_t SqlChangeStore::LastNumber() const {
  return access_.Read(
      [&](Database& database) { return database.Int(access_.dialect().last_change); });
}

int64_t SqlChangeStore::ForgottenThrough() const {
  return access_.Read(
      [](Database& database) { return database.Int("SELECT forgotten_through FROM feed"); });
}

ChangePage SqlChangeStore::List(int64_t after_number,
                                size_t limit,
                                const std::optional<ChangeArea>& area) const {
  const std::string sql = SelectChanges() +
                          "WHERE number > $1 AND ($2 = false OR (subject = 0 AND " + MeetsBox(4) +
                          ") OR (subject <> 0 AND " + MeetsBox(8) + ")) ORDER BY number LIMIT $3";
  const ChangeArea given = area.value_or(ChangeArea{});
  return access_.Read([&](Database& database) {
    ChangePage page;
    // Read first: a later change is for the next page.
    page.last_number = database.Int(access_.dialect().last_change);
    page.changes = database.Each(ChangeRowOf,
                                 sql,
                                 after_number,
                                 area.has_value(),
                                 static_cast<int64_t>(limit) + 1,
                                 given.sites.west_deg,
                                 given.sites.south_deg,
                                 given.sites.east_deg,
                                 given.sites.north_deg,
                                 given.surroundings.west_deg,
                                 given.surroundings.south_deg,
                                 given.surroundings.east_deg,
                                 given.surroundings.north_deg);
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

std::optional<ChangeRow> SqlChangeStore::Find(const ChangeKey& key) const {
  return access_.Read([&](Database& database) {
    return database.First(
        ChangeRowOf, SelectChanges() + "WHERE subject = $1 AND id = $2", SubjectOf(key), key.id);
  });
}

void SqlChangeStore::Repeat(const std::vector<ChangeKey>& keys) {
  const Dialect& dialect = access_.dialect();
  WriteChanges(access_, [&](Database& writer) {
    for (const ChangeKey& key : keys) {
      StepNumber(writer, dialect);
      writer.Change(
          "UPDATE changes SET number = " + dialect.new_change + " WHERE subject = $1 AND id = $2",
          SubjectOf(key),
          key.id);
    }
  });
}

void SqlChangeStore::SetOrigins(const std::vector<ChangeRow>& changes) {
  const Dialect& dialect = access_.dialect();
  const std::string origin = "CASE WHEN $3 = (SELECT id FROM feed) THEN '' ELSE $3 END";
  WriteChanges(access_, [&](Database& writer) {
    for (const ChangeRow& change : changes) {
      StepNumber(writer, dialect);
      writer.Change("UPDATE changes SET number = " + dialect.new_change + ", origin = " + origin +
                        " WHERE subject = $1 AND id = $2 AND origin <> " + origin,
                    SubjectOf(change.key),
                    change.key.id,
                    change.origin);
    }
  });
}

void SqlChangeStore::PutRemoval(const ChangeRow& removal) {
  const Dialect& dialect = access_.dialect();
  Values values{SubjectOf(removal.key),
                removal.key.id,
                static_cast<int>(removal.kind),
                removal.changed_at_us,
                removal.stamp_us,
                removal.origin};
  if (dialect.can_follow) values.emplace_back(removal.is_known_above);
  WriteChanges(access_, [&](Database& writer) {
    StepNumber(writer, dialect);
    writer.Update(
        std::string("INSERT INTO changes AS known (subject, id, number, kind, changed_at_us, "
                    "stamp_us, west_deg, south_deg, east_deg, north_deg, origin") +
            (dialect.can_follow ? ", is_known_above" : "") + ") VALUES ($1, $2, " +
            dialect.new_change + ", $3, $4, $5, -180, -90, 180, 90, $6" +
            (dialect.can_follow ? ", $7" : "") +
            ") ON CONFLICT (subject, id) DO UPDATE SET number = excluded.number, stamp_us = "
            "excluded.stamp_us, changed_at_us = excluded.changed_at_us "
            "WHERE known.kind >= 4 AND known.stamp_us < excluded.stamp_us",
        values);
  });
}

void SqlChangeStore::ForgetRemoved(int64_t before_us) {
  WriteChanges(access_, [&](Database& writer) {
    const int64_t last = writer.Int(
        "SELECT coalesce(max(number), 0) FROM changes WHERE kind >= 4 AND changed_at_us < $1",
        before_us);
    writer.Change("UPDATE feed SET forgotten_through = $1 WHERE forgotten_through < $1", last);
    writer.Change("DELETE FROM changes WHERE kind >= 4 AND changed_at_us < $1", before_us);
  });
}

std::vector<ChangeRow> SqlChangeStore::ListUnknownAbove(size_t limit) const {
  if (!access_.dialect().can_follow) return {};
  return access_.Read([&](Database& database) {
    return database.Each(ChangeRowOf,
                         SelectChanges() + "WHERE is_known_above = false ORDER BY number LIMIT $1",
                         static_cast<int64_t>(limit));
  });
}

void SqlChangeStore::SetKnownAbove(const std::vector<ChangeRow>& changes) {
  CheckThatItFollows();
  WriteChanges(access_, [&](Database& writer) {
    for (const ChangeRow& change : changes) {
      writer.Change(
          "UPDATE changes SET is_known_above = true WHERE subject = $1 AND id = $2 AND number = $3",
          SubjectOf(change.key),
          change.key.id,
          change.number);
    }
  });
}

void SqlChangeStore::SetAllUnknownAbove(const std::string& except_origin) {
  CheckThatItFollows();
  WriteChanges(access_, [&](Database& writer) {
    // What the former server had withdrawn is nobody's wish to remove it from another one.
    writer.Change("UPDATE changes SET is_known_above = false WHERE origin <> $1 AND kind < 4",
                  except_origin);
  });
}

std::optional<FollowState> SqlChangeStore::FindFollowState() const {
  if (!access_.dialect().can_follow) return std::nullopt;
  return access_.Read([](Database& database) {
    return database.First(
        [](const Row& row) {
          return FollowState{row.Text(0), row.Text(1), row.OptionalInt(2)};
        },
        "SELECT followed, next, in_step_at_us FROM follow_state");
  });
}

void SqlChangeStore::PutFollowState(const FollowState& state) {
  CheckThatItFollows();
  WriteChanges(access_, [&](Database& writer) {
    writer.Change("DELETE FROM follow_state");
    writer.Change("INSERT INTO follow_state VALUES ($1, $2, $3)",
                  state.followed,
                  state.next,
                  state.in_step_at_us);
  });
}

}  // namespace freelsd
