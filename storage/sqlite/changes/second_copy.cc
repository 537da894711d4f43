#include <optional>
#include <string>
#include <vector>

#include "storage/change_store.h"
#include "storage/sqlite/changes/changes.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/obstacle_rows.h"
#include "storage/sqlite/site_queries.h"

namespace freelsd {
namespace {

constexpr int64_t kChangesOfPage = 256;

struct CopyPlace {
  std::string feed;
  int64_t number = 0;

  bool operator==(const CopyPlace&) const = default;
};

CopyPlace PlaceOfMain(const Connection& main) {
  Statement statement = main.Prepare("SELECT id, number FROM feed");
  statement.Step();
  return {statement.Text(0), statement.Int(1)};
}

std::optional<CopyPlace> PlaceOfCopy(const Connection& copy) {
  Statement statement = copy.Prepare("SELECT followed, CAST(next AS INTEGER) FROM follow_state");
  if (!statement.Step()) return std::nullopt;
  return CopyPlace{statement.Text(0), statement.Int(1)};
}

int64_t CountOf(const Connection& connection, const char* sql) {
  Statement statement = connection.Prepare(sql);
  statement.Step();
  return statement.Int(0);
}

void CopySite(const Connection& from, const Connection& to, const std::string& id) {
  const auto site = On(from, [&](const Connection& c) { return FindWholeSiteRow(c, id); });
  if (!site) return (void)On(to, [&](const Connection& c) { return DeleteSiteRows(c, id); });
  On(to, [&](const Connection& c) { PutSiteRows(c, *site); });
}

void CopyObstacle(const Connection& from, const Connection& to, const std::string& id) {
  const auto obstacle = On(from, [&](const Connection& c) { return FindObstacleRow(c, id); });
  if (!obstacle) return (void)On(to, [&](const Connection& c) { return DeleteObstacleRow(c, id); });
  On(to, [&](const Connection& c) { PutObstacleRow(c, *obstacle); });
}

void CopyTiles(const Connection& from, const Connection& to, const std::string& map_id) {
  On(from, [&](const Connection& reader) {
    Statement tiles = reader.Prepare(
        "SELECT level, row, col, tile FROM map_tiles WHERE map_id = ?1 ORDER BY rowid");
    tiles.Bind(map_id);
    while (tiles.Step()) {
      const TileKey key{tiles.Int(0), tiles.Int(1), tiles.Int(2)};
      On(to, [&](const Connection& c) { PutTileRows(c, map_id, {{key, tiles.Text(3)}}); });
    }
  });
}

// The map may lie in `to` already, not in force: its tiles were staged there.
void CopyMap(const Connection& from, const Connection& to, const std::string& id) {
  const auto content = [&id](const Connection& c) { return MapContentOf(c, id); };
  const std::optional<MapContent> wanted = On(from, content), present = On(to, content);
  if (!wanted || !wanted->is_in_force) {
    return On(to, [&](const Connection& c) { DeleteMapRow(c, id); });
  }
  if (present && present->checksum == wanted->checksum && present->num_tiles == wanted->num_tiles) {
    return On(to, [&](const Connection& c) { PutMapInForce(c, id); });
  }
  const auto map = On(from, [&](const Connection& c) { return FindMapRow(c, id); });
  if (!map) return;
  On(to, [&](const Connection& c) {
    DeleteMapRow(c, id);
    PutMapRow(c, *map, true);
  });
  CopyTiles(from, to, id);
}

// Calls `copy` for each id whose stamps differ.
template <typename Stamps, typename Copy>
void CopyDifferent(const Stamps& wanted, const Stamps& present, const Copy& copy) {
  for (const auto& [id, stamp] : present) {
    if (!wanted.contains(id)) copy(id);
  }
  for (const auto& [id, stamp] : wanted) {
    const auto found = present.find(id);
    if (found == present.end() || !(found->second == stamp)) copy(id);
  }
}

std::vector<ChangeRow> ChangesAfter(const Connection& main, int64_t number) {
  Statement statement = main.Prepare(
      "SELECT subject, id, number FROM changes WHERE number > ?1 ORDER BY number LIMIT ?2");
  statement.Bind(number, kChangesOfPage);
  std::vector<ChangeRow> changes;
  while (statement.Step()) {
    ChangeRow change;
    change.key = {static_cast<ChangeSubject>(statement.Int(0)), statement.Text(1)};
    change.number = statement.Int(2);
    changes.push_back(std::move(change));
  }
  return changes;
}

// As it is now: whether the change stored or removed it does not matter.
void CopyChanged(const Connection& from, const Connection& to, const ChangeKey& key) {
  if (key.subject == ChangeSubject::kSite) return CopySite(from, to, key.id);
  if (key.subject == ChangeSubject::kMap) return CopyMap(from, to, key.id);
  CopyObstacle(from, to, key.id);
}

}  // namespace

NumStored NumStoredIn(const Connection& connection) {
  return {CountOf(connection, "SELECT count(*) FROM sites"),
          CountOf(connection, "SELECT count(*) FROM maps WHERE is_in_force = 1"),
          CountOf(connection, "SELECT count(*) FROM obstacles")};
}

bool IsSame(const Connection& a, const Connection& b) {
  return On(a, StampsOf) == On(b, StampsOf) && On(a, ObstacleStampsOf) == On(b, ObstacleStampsOf) &&
         On(a, MapStampsOf) == On(b, MapStampsOf);
}

void CopyAll(const Connection& from, const Connection& to) {
  CopyDifferent(
      On(from, StampsOf), On(to, StampsOf), [&](const std::string& id) { CopySite(from, to, id); });
  CopyDifferent(On(from, ObstacleStampsOf), On(to, ObstacleStampsOf), [&](const std::string& id) {
    CopyObstacle(from, to, id);
  });
  CopyDifferent(On(from, MapStampsOf), On(to, MapStampsOf), [&](const std::string& id) {
    CopyMap(from, to, id);
  });
  if (IsSame(from, to)) return;
  // A table has a row that an index does not have.
  On(from, [](const Connection&) {
    throw StorageError("copy the sites", "an index is damaged", StorageFault::kDamaged);
  });
}

int64_t LastChangeOf(const Connection& main) { return PlaceOfMain(main).number; }

bool IsInStep(const Connection& main, const Connection& copy) {
  return On(copy, PlaceOfCopy) == PlaceOfMain(main);
}

bool CanFollow(const Connection& main, const Connection& copy) {
  const CopyPlace place = PlaceOfMain(main);
  const auto known = On(copy, PlaceOfCopy);
  return known && known->feed == place.feed && known->number <= place.number &&
         known->number >= CountOf(main, "SELECT forgotten_through FROM feed");
}

void FollowMain(const Connection& main, const Connection& copy) {
  int64_t number = On(copy, PlaceOfCopy)->number;
  while (true) {
    const std::vector<ChangeRow> changes = ChangesAfter(main, number);
    if (changes.empty()) return;
    for (const ChangeRow& change : changes) CopyChanged(main, copy, change.key);
    number = changes.back().number;
  }
}

void SetInStep(const Connection& main, const Connection& copy) {
  const CopyPlace place = PlaceOfMain(main);
  On(copy, [&place](const Connection& writer) {
    if (PlaceOfCopy(writer) == place) return;
    writer.Execute("DELETE FROM follow_state");
    writer
        .Prepare(
            "INSERT INTO follow_state VALUES (?1, ?2, "
            "CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER))")
        .Bind(place.feed, std::to_string(place.number))
        .Run();
  });
}

std::string InStepAt(const Connection& copy) {
  Statement statement = copy.Prepare(
      "SELECT strftime('%Y-%m-%dT%H:%M:%SZ', in_step_at_us / 1000000, 'unixepoch') "
      "FROM follow_state");
  return statement.Step() ? statement.Text(0) : std::string();
}

}  // namespace freelsd
