// Sites and their maps. Both stay when the flight that found them is deleted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace freelsd {

// WGS84. A box with west > east crosses the antimeridian.
struct BoundingBox {
  double west_deg, south_deg, east_deg, north_deg;
};

// Data by which emergency recall ranks a site before it reads the site's whole row.
struct RecallData {
  bool is_landable = false;  // false: unverified
  double altitude_m = 0.0;   // of the touchdown, in altitude_datum
  std::string altitude_datum = "unknown";
  double score = 0.0;
  std::string aircraft_json = "{}";
};

struct Standing;

// A recallable site, without its feature and approach.
struct RecallRow {
  std::string site_id;
  std::string flight_id;
  // As in SiteRow.
  std::string map_id;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  int64_t updated_at_us = 0;
  // When the ground was last photographed, as in SiteRow. Later maps on which the plan holds count
  // too.
  int64_t seen_at_us = 0;
  RecallData data;
  std::optional<int64_t> seen_until_us = std::nullopt;
  // Of a site that is doubted; else null.
  std::shared_ptr<const Standing> doubt = nullptr;
};

// Result of a query that may return thousands of rows. Rows are shared, not copied.
template <typename Row>
using SharedRows = std::vector<std::shared_ptr<const Row>>;

// Result of checking a site's stored plan on the maps that are later, or may be.
struct Standing {
  // Id of the site on whose map the plan fails. If there are several, the one whose map was
  // photographed last. On a flight's map: the nearest of its sites, or the flight if it has none.
  // Empty: the site is not superseded, but a later map may doubt it (IsDoubted).
  std::optional<std::string> superseded_by;
  // Id of that map, or of the one that doubts.
  std::string superseded_by_map;
  // The time at which the ground of that map was last photographed, the broken rule, and a sentence
  // with numbers. With a rule, 0 means that the order of the two maps is not known.
  int64_t superseded_at_us = 0;
  std::string superseded_reason;
  std::string superseded_detail;
  // Time of the latest photographs of another map on which the plan holds.
  std::optional<int64_t> confirmed_at_us;

  // The plan breaks a rule on a later map, which does not positively show that the ground changed.
  // Map, time, rule and sentence are those of the latest one that is later than confirmed_at_us.
  bool IsDoubted() const { return !superseded_by && !superseded_reason.empty(); }
  // Of the site or flight whose map supersedes, or of the flight whose map doubts.
  std::string JudgeId() const {
    return superseded_by.value_or(superseded_by_map.substr(0, superseded_by_map.find('/')));
  }
  bool operator==(const Standing&) const = default;
  // The plan fails on a map that may be later or earlier: neither replaces the other, and the worse
  // of both holds. Else, superseded_by is of a later map.
  bool IsContested() const {
    return superseded_by && superseded_at_us == 0 && !superseded_reason.empty();
  }
};

// A site. Columns and units are those of schema.sql.
struct SiteRow : Standing {
  std::string id;
  std::string flight_id;
  int64_t region_id = 0;
  // The flight's map that the site lies on. Empty if nothing was reconstructed.
  std::string map_id;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  // GeoJSON feature; has no rank, because the rank depends on the flight's other sites.
  std::string feature_json;
  // FeatureCollection of the approach; empty if the site has no approach.
  std::string approach_json;
  // Input for planning the site again on its map: region, aircraft, origin, datum.
  std::string replan_json;
  int64_t updated_at_us = 0;
  // When its ground was last photographed for its map, at the earliest. 0: unknown.
  int64_t seen_at_us = 0;
  // The same at the latest. Empty: the time is exact; of an unknown time, there is no bound.
  std::optional<int64_t> seen_until_us = std::nullopt;
  // Empty: recall never returns the site, because it was rejected or no terrain was seen.
  std::optional<RecallData> recall;
  // Datum of the map's altitudes if `recall` is empty. Otherwise recall->altitude_datum is used.
  std::string map_datum = "unknown";
  // Area of the map around the site. If empty, the site's box is its touchdown point.
  std::optional<BoundingBox> map_box;

  // When the ground was last photographed: for its map, or for a later one that confirms the plan.
  int64_t LastSeenUs() const { return std::max(seen_at_us, confirmed_at_us.value_or(seen_at_us)); }
};

// A flight's map in force, without its head.
struct MapRow {
  std::string id;
  std::string flight_id;
  std::string altitude_datum;
  // When the ground of this map was last photographed, as in SiteRow.
  int64_t seen_at_us = 0;
  std::optional<int64_t> seen_until_us = std::nullopt;
};

// The result of an evaluation: what one commit changes.
struct EvaluationRows {
  std::vector<SiteRow> sites;
  std::vector<std::string> forgotten_sites;
  // Staged maps that come in force.
  std::vector<std::string> new_maps;
  std::vector<std::string> forgotten_maps;
  // Deleted as by FlightStore::Delete.
  std::optional<std::string> deleted_flight = {};
  // Told by the server that this one follows (ChangeRow::is_known_above).
  bool is_from_above = false;
  // Those whose rows that server does not know all the same.
  std::vector<std::string> sites_unknown_above = {};
};

// Standings to write, by site id.
using Standings = std::vector<std::pair<std::string, Standing>>;

// Bounds that hold for all recallable sites. They limit how far away a reachable site can be.
struct RecallBounds {
  double min_altitude_m = 0.0;
  // Each distinct aircraft for which a recallable site was planned.
  std::vector<std::string> aircraft_jsons;
};

// A turn to change sites. While it lasts nobody else has one, in this process or in another, so
// that what is read meanwhile about sites and about maps in force stays true. It ends with the
// first of its writes, or unused with its lifetime. A turn that lasts longer than a minute may be
// lost: its write then throws StorageError and changes nothing.
class SiteTurn {
 public:
  virtual ~SiteTurn() = default;
  SiteTurn(const SiteTurn&) = delete;
  SiteTurn& operator=(const SiteTurn&) = delete;

  // Applies the result of an evaluation and the standings of other sites in one commit.
  virtual void PutEvaluation(const EvaluationRows& rows, const Standings& others) = 0;
  // Deletes the site, and writes the standings of other sites in the same commit. If there is no
  // such site, writes nothing and returns false.
  virtual bool Delete(const std::string& site_id, const Standings& others) = 0;
  virtual void SetStandings(const Standings& standings) = 0;

 protected:
  SiteTurn() = default;
};

// Invariant of SQLite: each site, its map and its box are stored in two databases. If the main
// database is damaged, sites are read from the second copy.
class SiteStore {
 public:
  virtual ~SiteStore() = default;
  SiteStore(const SiteStore&) = delete;
  SiteStore& operator=(const SiteStore&) = delete;

  // Waits for the turn; what a thread with a turn must not do.
  virtual std::unique_ptr<SiteTurn> TakeTurn() = 0;
  // Each of them takes a turn for itself.
  void PutEvaluation(const EvaluationRows& rows, const Standings& others) {
    TakeTurn()->PutEvaluation(rows, others);
  }
  bool Delete(const std::string& site_id, const Standings& others = {}) {
    return TakeTurn()->Delete(site_id, others);
  }
  void SetStandings(const Standings& standings) { TakeTurn()->SetStandings(standings); }

  // Rows from Find and List have no recall, map_box and map_datum.
  virtual std::optional<SiteRow> Find(const std::string& site_id) const = 0;
  virtual std::vector<SiteRow> List(const std::optional<std::string>& flight_id,
                                    const std::optional<BoundingBox>& box) const = 0;
  // With recall, map_box and map_datum.
  virtual std::optional<SiteRow> FindWhole(const std::string& site_id) const = 0;
  // A number that increases with every change of a site. It has increased before the changing call
  // returns.
  virtual uint64_t Version() const = 0;
  // Ids of sites whose standing names this site.
  virtual std::vector<std::string> ListDependents(const std::string& site_id) const = 0;
  // Ids of sites whose standing depends on this map.
  virtual std::vector<std::string> ListDependentsOfMap(const std::string& map_id) const = 0;
  // Maps in force that may meet the box.
  virtual SharedRows<MapRow> ListMaps(const BoundingBox& box) const = 0;
  // Ids of sites with an approach, superseded ones and those of experiments included, whose map or
  // touchdown may meet the box.
  virtual std::vector<std::string> ListAccepted(const BoundingBox& box) const = 0;

  // Recallable sites whose map or touchdown intersects the box.
  virtual SharedRows<RecallRow> ListRecallable(const BoundingBox& box) const = 0;
  virtual int64_t CountRecallable() const = 0;
  // Whether any site of the flight may be recalled.
  virtual bool HasRecallable(const std::string& flight_id) const = 0;
  virtual RecallBounds BoundsOfRecallable() const = 0;
  // Number of accepted sites that recall leaves out because they are superseded. Only sites with a
  // map in the box are counted.
  virtual int64_t CountOverruled(const BoundingBox& box) const = 0;

 protected:
  SiteStore() = default;
};

}  // namespace freelsd
