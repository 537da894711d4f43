// Sites and their maps. Both stay when the flight that found them is deleted.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct StorageState;

// WGS84. A box with west > east crosses the antimeridian.
struct BoundingBox {
  double west_deg, south_deg, east_deg, north_deg;
};

// The data of a site by which emergency recall ranks it before it reads the whole row.
struct RecallData {
  bool is_landable = false;  // false: unverified
  double altitude_m = 0.0;   // of the touchdown, in altitude_datum
  std::string altitude_datum = "unknown";
  double score = 0.0;
  std::string aircraft_json = "{}";
};

// A recallable site, without its feature and approach.
struct RecallRow {
  std::string site_id;
  std::string flight_id;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  int64_t updated_at_us = 0;
  int64_t seen_at_us = 0;
  RecallData data;
};

// Rows that a query returns by the thousand; they are shared, not copied.
template <typename Row>
using SharedRows = std::vector<std::shared_ptr<const Row>>;

// A site. Columns and units are those of schema.sql.
struct SiteRow {
  std::string id;
  std::string flight_id;
  int64_t region_id = 0;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  // GeoJSON feature; has no rank, because the rank depends on the flight's other sites.
  std::string feature_json;
  // FeatureCollection of the approach; empty: the site has no approach.
  std::string approach_json;
  // Input for planning the site again on its map: region, aircraft, origin, datum.
  std::string replan_json;
  int64_t updated_at_us = 0;
  // When the ground was last photographed; a later site supersedes earlier ones on the same ground.
  int64_t seen_at_us = 0;
  // The verdict depends on the ground itself, so this site may supersede earlier sites there.
  bool is_evidence = false;
  // Empty: recall never returns the site, because it was rejected or no terrain was seen.
  std::optional<RecallData> recall;
  // Area of the map; empty: the box is the touchdown point.
  std::optional<BoundingBox> map_box;
  // Id of the site that a later flight found on the same ground.
  std::optional<std::string> superseded_by;
};

// Identifies one version of a site's map.
struct MapRow {
  std::string site_id;
  int64_t updated_at_us = 0;
  std::string altitude_datum;
};

// Bounds that hold for all recallable sites; the greatest reach of a glide follows from them.
struct RecallBounds {
  double min_altitude_m = 0.0;
  // Each distinct aircraft for which a recallable site was planned.
  std::vector<std::string> aircraft_jsons;
};

// Invariant: each site, its map and its box are stored in two databases. If the main database is
// damaged, sites are read from the second copy.
class SiteStore {
 public:
  explicit SiteStore(StorageState& state) : state_(state) {}
  SiteStore(const SiteStore&) = delete;
  SiteStore& operator=(const SiteStore&) = delete;

  // Inserts or replaces the site and its map (empty: no map) in one commit. `supersedes`: ids of
  // sites on the same ground that recall leaves out while this site exists.
  void Put(const SiteRow& site,
           std::string_view map_blob,
           const std::vector<std::string>& supersedes = {});
  // Sets SiteRow::superseded_by; nothing: no site supersedes it any more.
  void SetSupersededBy(const std::string& site_id, const std::optional<std::string>& newer_id);
  bool Delete(const std::string& site_id);

  // Rows from Find and List have neither recall nor map_box.
  std::optional<SiteRow> Find(const std::string& site_id) const;
  std::vector<SiteRow> List(const std::optional<std::string>& flight_id,
                            const std::optional<BoundingBox>& box) const;
  std::optional<std::string> ReadMap(const std::string& site_id) const;
  // All sites, rejected ones included, whose map may meet the box.
  SharedRows<MapRow> ListMaps(const BoundingBox& box) const;

  // Recallable sites whose map or touchdown meets the box.
  SharedRows<RecallRow> ListRecallable(const BoundingBox& box) const;
  int64_t CountRecallable() const;
  RecallBounds BoundsOfRecallable() const;
  // Sites in the box that recall leaves out because a later site rejected their ground.
  int64_t CountOverruled(const BoundingBox& box) const;

 private:
  StorageState& state_;
};

}  // namespace freelsd
