#include "storage/stores/stores.h"

namespace freelsd {
namespace {

constexpr BoundingBox kWholeEarth{-180.0, -90.0, 180.0, 90.0};

class SqlSiteTurn final : public SiteTurn {
 public:
  SqlSiteTurn(StoreAccess& access, const SiteQueries& queries)
      : dialect_(access.dialect()), queries_(queries), turn_(access.TakeTurn()) {}

  void PutEvaluation(const EvaluationRows& rows, const Standings& others) override {
    turn_->Write(rows.is_from_above ? Teller::kAbove : Teller::kThisServer,
                 [&](Writer& writer) { PutRows(writer, rows, others); });
  }
  bool Delete(const std::string& site_id, const Standings& others) override {
    bool was_there = false;
    turn_->Write(Teller::kThisServer, [&](Writer& writer) {
      was_there = queries_.remove(*writer, site_id);
      if (was_there) PutStandings(*writer, others);
    });
    return was_there;
  }
  void SetStandings(const Standings& standings) override {
    if (standings.empty()) return turn_.reset();
    turn_->Write(Teller::kThisServer, [&](Writer& writer) { PutStandings(*writer, standings); });
  }

 private:
  void PutRows(Writer& writer, const EvaluationRows& rows, const Standings& others) const;

  const Dialect& dialect_;
  SiteQueries queries_;
  std::unique_ptr<Turn> turn_;
};

void SqlSiteTurn::PutRows(Writer& writer,
                          const EvaluationRows& rows,
                          const Standings& others) const {
  for (const std::string& id : rows.forgotten_sites) queries_.remove(*writer, id);
  for (const std::string& id : rows.forgotten_maps) {
    const std::vector<std::string> images =
        writer->Texts("SELECT DISTINCT sha256 FROM photo_tiles WHERE map_id = $1", id);
    writer.unused_images.insert(writer.unused_images.end(), images.begin(), images.end());
    DeleteMapRow(*writer, id);
  }
  for (const std::string& id : rows.new_maps) PutMapInForce(*writer, id);
  for (const SiteRow& site : rows.sites) queries_.put(*writer, site);
  PutStandings(*writer, others);
  if (dialect_.can_follow) {
    for (const std::string& id : rows.sites_unknown_above) {
      writer->Change("UPDATE changes SET is_known_above = false WHERE subject = 0 AND id = $1", id);
    }
  }
  if (rows.deleted_flight) DeleteFlightRow(writer, dialect_, *rows.deleted_flight);
}

}  // namespace

const char* const kStandingColumns =
    "superseded_by, superseded_at_us, superseded_reason, superseded_detail, confirmed_at_us, "
    "superseded_by_map";

Standing StandingAt(const Row& row, int first_column) {
  Standing standing;
  if (std::string id = row.Text(first_column); !id.empty()) standing.superseded_by = std::move(id);
  standing.superseded_at_us = row.OptionalInt(first_column + 1).value_or(0);
  standing.superseded_reason = row.Text(first_column + 2);
  standing.superseded_detail = row.Text(first_column + 3);
  standing.confirmed_at_us = row.OptionalInt(first_column + 4);
  standing.superseded_by_map = row.Text(first_column + 5);
  return standing;
}

void PutStandings(Database& writer, const Standings& standings) {
  for (const auto& [id, standing] : standings) {
    writer.Change(
        "UPDATE sites SET superseded_by = nullif($2, ''), superseded_at_us = nullif($3, 0), "
        "superseded_reason = $4, superseded_detail = $5, confirmed_at_us = $6, "
        "superseded_by_map = $7 WHERE id = $1",
        id,
        standing.superseded_by.value_or(""),
        standing.superseded_at_us,
        standing.superseded_reason,
        standing.superseded_detail,
        standing.confirmed_at_us,
        standing.superseded_by_map);
  }
}

BoundingBox BoxAt(const Row& row, int first_column) {
  return {row.Real(first_column),
          row.Real(first_column + 1),
          row.Real(first_column + 2),
          row.Real(first_column + 3)};
}

const char* const kSiteColumns =
    "id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json, "
    "replan_json, updated_at_us, seen_at_us, map_id, superseded_by, superseded_at_us, "
    "superseded_reason, superseded_detail, confirmed_at_us, superseded_by_map, "
    "seen_until_us";

SiteRow SiteRowOf(const Row& row) {
  SiteRow site;
  site.id = row.Text(0);
  site.flight_id = row.Text(1);
  site.region_id = row.Int(2);
  site.latitude_deg = row.Real(3);
  site.longitude_deg = row.Real(4);
  site.feature_json = row.Text(5);
  site.approach_json = row.Text(6);
  site.replan_json = row.Text(7);
  site.updated_at_us = row.Int(8);
  site.seen_at_us = row.Int(9);
  site.map_id = row.Text(10);
  static_cast<Standing&>(site) = StandingAt(row, 11);
  site.seen_until_us = row.OptionalInt(17);
  return site;
}

std::unique_ptr<SiteTurn> SqlSiteStore::TakeTurn() {
  return std::make_unique<SqlSiteTurn>(access_, queries_);
}

std::optional<SiteRow> SqlSiteStore::Find(const std::string& site_id) const {
  return access_.FindInEither([&](Database& database) { return queries_.find(database, site_id); });
}

std::optional<SiteRow> SqlSiteStore::FindWhole(const std::string& site_id) const {
  return access_.FindInEither(
      [&](Database& database) { return queries_.find_whole(database, site_id); });
}

std::vector<SiteRow> SqlSiteStore::List(const std::optional<std::string>& flight_id,
                                        const std::optional<BoundingBox>& box) const {
  const auto list = [&](Database& database) {
    return queries_.list(database, flight_id, box.value_or(kWholeEarth));
  };
  return access_.Read(list, Reading::kSites);
}

std::vector<std::string> SqlSiteStore::ListDependents(const std::string& site_id) const {
  const auto list = [&](Database& database) {
    return database.Texts("SELECT id FROM sites WHERE superseded_by = $1 ORDER BY id", site_id);
  };
  return access_.Read(list, Reading::kSites);
}

std::vector<std::string> SqlSiteStore::ListDependentsOfMap(const std::string& map_id) const {
  const auto list = [&](Database& database) {
    return database.Texts(
        "SELECT id FROM sites WHERE superseded_by_map = $1 UNION SELECT id FROM sites "
        "WHERE confirmed_at_us = (SELECT seen_at_us FROM maps WHERE id = $1) ORDER BY id",
        map_id);
  };
  return access_.Read(list, Reading::kSites);
}

std::vector<std::string> SqlSiteStore::ListAccepted(const BoundingBox& box) const {
  std::vector<std::string> ids = access_.Read(
      [&](Database& database) { return queries_.list_accepted(database, box); }, Reading::kSites);
  std::sort(ids.begin(), ids.end());
  return ids;
}

SharedRows<MapRow> SqlSiteStore::ListMaps(const BoundingBox& box) const {
  return Within(map_rows_, box, queries_.list_maps);
}

SharedRows<RecallRow> SqlSiteStore::ListRecallable(const BoundingBox& box) const {
  return Within(recall_rows_, box, queries_.list_recallable);
}

int64_t SqlSiteStore::CountOverruled(const BoundingBox& box) const {
  return static_cast<int64_t>(Within(overruled_ids_, box, queries_.list_overruled).size());
}

int64_t SqlSiteStore::CountRecallable() const {
  const auto count = [&](Database& database) {
    return database.Int("SELECT count(*) FROM " + access_.dialect().recallable_sites +
                        " WHERE is_recallable = true AND superseded_by IS NULL");
  };
  return access_.Read(count, Reading::kRecall);
}

bool SqlSiteStore::HasRecallable(const std::string& flight_id) const {
  const auto has = [&](Database& database) {
    return database.Has("SELECT 1 FROM " + access_.dialect().recallable_sites +
                            " WHERE flight_id = $1 AND is_recallable = true LIMIT 1",
                        flight_id);
  };
  return access_.Read(has, Reading::kSites);
}

RecallBounds SqlSiteStore::BoundsOfRecallable() const {
  const uint64_t version = Version();
  {
    const std::lock_guard lock(bounds_mutex_);
    if (bounds_version_ == version) return bounds_;
  }
  RecallBounds bounds = access_.Read(queries_.find_bounds, Reading::kRecall);
  const std::lock_guard lock(bounds_mutex_);
  bounds_version_ = version;
  return bounds_ = std::move(bounds);
}

}  // namespace freelsd
