#include <map>
#include <optional>
#include <string>
#include <vector>

#include "storage/change_store.h"
#include "storage/sqlite/changes.h"
#include "storage/sqlite/site_queries.h"

namespace freelsd {
namespace {

constexpr int64_t kChangesOfPage = 256;

struct CopyPlace {
  std::string feed;
  int64_t number = 0;

  bool operator==(const CopyPlace&) const = default;
};

CopyPlace PlaceOf(const Row& row) { return {row.Text(0), row.Int(1)}; }

CopyPlace PlaceOfMain(Connection& main) {
  return main.First(PlaceOf, "SELECT id, number FROM feed").value_or(CopyPlace{});
}

std::optional<CopyPlace> PlaceOfCopy(Connection& copy) {
  return copy.First(PlaceOf, "SELECT followed, CAST(next AS INTEGER) FROM follow_state");
}

// Values by which two copies of a site are compared.
struct SiteStamp {
  int64_t updated_at_us = 0;
  Standing standing;

  bool operator==(const SiteStamp&) const = default;
};

std::map<std::string, SiteStamp> SiteStampsOf(Connection& connection) {
  std::map<std::string, SiteStamp> stamps;
  const std::string sql =
      std::string("SELECT id, updated_at_us, ") + kStandingColumns + " FROM sites";
  connection.Select(sql, {}, [&stamps](const Row& row) {
    stamps.insert({row.Text(0), {row.Int(1), StandingAt(row, 2)}});
    return true;
  });
  return stamps;
}

// Checksums by id, of obstacles and of maps in force: a stored map never changes.
std::map<std::string, int64_t> ChecksumsIn(Connection& connection, const std::string& sql) {
  std::map<std::string, int64_t> checksums;
  connection.Select(sql, {}, [&checksums](const Row& row) {
    checksums[row.Text(0)] = row.Int(1);
    return true;
  });
  return checksums;
}

std::map<std::string, int64_t> ObstacleStampsOf(Connection& connection) {
  return ChecksumsIn(connection, "SELECT id, checksum FROM obstacles");
}

std::map<std::string, int64_t> MapStampsOf(Connection& connection) {
  return ChecksumsIn(connection, "SELECT id, checksum FROM maps WHERE is_in_force = 1");
}

struct MapContent {
  int64_t checksum = 0;
  bool is_in_force = false;
  int64_t num_tiles = 0;
};

// Nothing if there is no such map.
std::optional<MapContent> MapContentOf(Connection& connection, const std::string& map_id) {
  return connection.First(
      [](const Row& row) {
        return MapContent{row.Int(0), row.Bool(1), row.Int(2)};
      },
      "SELECT checksum, is_in_force, (SELECT count(*) FROM map_tiles WHERE map_id = id) "
      "FROM maps WHERE id = $1",
      map_id);
}

void CopySite(Connection& from, Connection& to, const std::string& id) {
  const auto site = On(from, [&](Connection& c) { return FindWholeSiteRow(c, id); });
  if (!site) return (void)On(to, [&](Connection& c) { return DeleteSiteRows(c, id); });
  On(to, [&](Connection& c) { PutSiteRows(c, *site); });
}

void CopyObstacle(Connection& from, Connection& to, const std::string& id) {
  const auto obstacle = On(from, [&](Connection& c) { return FindObstacleRow(c, id); });
  if (!obstacle) return (void)On(to, [&](Connection& c) { return DeleteObstacleRow(c, id); });
  On(to, [&](Connection& c) { PutObstacleRow(c, *obstacle); });
}

void CopyTiles(Connection& from, Connection& to, const std::string& map_id) {
  const auto copy = [&](const Row& tile) {
    const TileKey key{tile.Int(0), tile.Int(1), tile.Int(2)};
    On(to, [&](Connection& c) { PutTileRows(c, map_id, {{key, tile.Text(3)}}); });
    return true;
  };
  On(from, [&](Connection& c) {
    c.Select("SELECT level, row, col, tile FROM map_tiles WHERE map_id = $1 ORDER BY rowid",
             {map_id},
             copy);
  });
}

// The map may lie in `to` already, not in force: its tiles were staged there.
void CopyMap(Connection& from, Connection& to, const std::string& id) {
  const auto content = [&id](Connection& c) { return MapContentOf(c, id); };
  const std::optional<MapContent> wanted = On(from, content), present = On(to, content);
  if (!wanted || !wanted->is_in_force) {
    return On(to, [&](Connection& c) { DeleteMapRow(c, id); });
  }
  if (present && present->checksum == wanted->checksum && present->num_tiles == wanted->num_tiles) {
    return On(to, [&](Connection& c) { PutMapInForce(c, id); });
  }
  const auto map = On(from, [&](Connection& c) { return FindMapRow(c, id); });
  if (!map) return;
  On(to, [&](Connection& c) {
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

std::vector<ChangeRow> ChangesAfter(Connection& main, int64_t number) {
  return main.Each(
      [](const Row& row) {
        ChangeRow change;
        change.key = {static_cast<ChangeSubject>(row.Int(0)), row.Text(1)};
        change.number = row.Int(2);
        return change;
      },
      "SELECT subject, id, number FROM changes WHERE number > $1 ORDER BY number LIMIT $2",
      number,
      kChangesOfPage);
}

// As it is now: whether the change stored or removed it does not matter.
void CopyChanged(Connection& from, Connection& to, const ChangeKey& key) {
  if (key.subject == ChangeSubject::kSite) return CopySite(from, to, key.id);
  if (key.subject == ChangeSubject::kMap) return CopyMap(from, to, key.id);
  CopyObstacle(from, to, key.id);
}

}  // namespace

NumStored NumStoredIn(Connection& connection) {
  return {connection.Int("SELECT count(*) FROM sites"),
          connection.Int("SELECT count(*) FROM maps WHERE is_in_force = 1"),
          connection.Int("SELECT count(*) FROM obstacles")};
}

bool IsSame(Connection& a, Connection& b) {
  return On(a, SiteStampsOf) == On(b, SiteStampsOf) &&
         On(a, ObstacleStampsOf) == On(b, ObstacleStampsOf) &&
         On(a, MapStampsOf) == On(b, MapStampsOf);
}

void CopyAll(Connection& from, Connection& to) {
  CopyDifferent(On(from, SiteStampsOf), On(to, SiteStampsOf), [&](const std::string& id) {
    CopySite(from, to, id);
  });
  CopyDifferent(On(from, ObstacleStampsOf), On(to, ObstacleStampsOf), [&](const std::string& id) {
    CopyObstacle(from, to, id);
  });
  CopyDifferent(On(from, MapStampsOf), On(to, MapStampsOf), [&](const std::string& id) {
    CopyMap(from, to, id);
  });
  if (IsSame(from, to)) return;
  // A table has a row that an index does not have.
  On(from, [](Connection&) {
    throw StorageError("copy the sites", "an index is damaged", StorageFault::kDamaged);
  });
}

int64_t LastChangeOf(Connection& main) { return PlaceOfMain(main).number; }

bool IsInStep(Connection& main, Connection& copy) {
  return On(copy, PlaceOfCopy) == PlaceOfMain(main);
}

bool CanFollow(Connection& main, Connection& copy) {
  const CopyPlace place = PlaceOfMain(main);
  const auto known = On(copy, PlaceOfCopy);
  return known && known->feed == place.feed && known->number <= place.number &&
         known->number >= main.Int("SELECT forgotten_through FROM feed");
}

void FollowMain(Connection& main, Connection& copy) {
  int64_t number = On(copy, PlaceOfCopy)->number;
  while (true) {
    const std::vector<ChangeRow> changes = ChangesAfter(main, number);
    if (changes.empty()) return;
    for (const ChangeRow& change : changes) CopyChanged(main, copy, change.key);
    number = changes.back().number;
  }
}

void SetInStep(Connection& main, Connection& copy) {
  const CopyPlace place = PlaceOfMain(main);
  On(copy, [&place](Connection& writer) {
    if (PlaceOfCopy(writer) == place) return;
    writer.Execute("DELETE FROM follow_state");
    writer.Change(
        "INSERT INTO follow_state VALUES ($1, $2, "
        "CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER))",
        place.feed,
        std::to_string(place.number));
  });
}

std::string InStepAt(Connection& copy) {
  const std::vector<std::string> found = copy.Texts(
      "SELECT strftime('%Y-%m-%dT%H:%M:%SZ', in_step_at_us / 1000000, 'unixepoch') "
      "FROM follow_state");
  return found.empty() ? "" : found.front();
}

}  // namespace freelsd
