// Converts text and blobs of database rows to structs and back. Only this code parses rows. All
// other code uses the structs.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "api/api.h"

namespace freelsd {

// --- A flight's request and rig, and a frame's pose ---

// Rig and origin of a flight, set by its first frame with a position. JSON keeps every number
// exactly.
struct FlightRig {
  Rig rig;
  GeoPoint origin;
  // Common datum of the positions of all resolved frames: "amsl" or "ellipsoid". It is "unknown" if
  // a position has no datum, or if two datums differ. Empty if no frame is resolved yet.
  std::optional<std::string> altitude_datum;
};
std::string FlightRigJson(const FlightRig& flight_rig);
FlightRig ParseStoredFlightRig(const std::string& text);

// A stored flight request without the options of the engine, which are most of its text. Reading it
// takes a small part of the time of ParseFlightRequest.
struct StoredFlight {
  std::optional<Camera> camera;
  std::optional<GeoPoint> origin;
  std::optional<std::string> altitude_datum;
  Aircraft aircraft;
  FlightMemory memory;
};
// `request_json` is FlightRequest::canonical_json.
StoredFlight ParseStoredFlight(const std::string& request_json);

// Equal metas give equal bytes. ParseStoredFrameMeta reads exactly the same numbers back.
std::string FrameMetaJson(const FrameMeta& meta);
FrameMeta ParseStoredFrameMeta(const std::string& text);
// The pose of a frame's row. `resolved_json` is the pose that the engine used. If it is empty, the
// pose is the meta sent with the image, completed by the image's own tags.
FrameMeta ParseStoredPose(const std::string& resolved_json,
                          const std::string& meta_json,
                          const std::string& tags_json);

// --- A site ---

// The straight final and the loiter circle before it.
struct FinalPlaces {
  GeoPoint start;
  GeoPoint loiter_center;  // at the altitude of the start
  double loiter_radius_m = 0.0;
  bool is_right_turn = false;
  // Direction of travel at the touchdown, from true north there, 0 to 360.
  double heading_deg = 0.0;
  // Horizontal distance from the start to the touchdown, at the altitude of flight. It exceeds the
  // distance on the ellipsoid.
  double distance_m = 0.0;
  // Height of the start above the touchdown.
  double height_m = 0.0;
  // Closed line, as stored.
  std::vector<GeoPoint> circle;
};

// The climb of a go-around.
struct StoredGoAround {
  // Distance from the point of no return, where the climb starts, to the touchdown.
  double no_return_distance_m = 0.0;
  double unseen_ratio = 0.0;
  GeoPoint start;
  GeoPoint end;
};

// Altitudes along the final. `terrain_m` is empty where no image shows the ground.
struct ProfilePoint {
  double distance_m = 0.0;  // before the touchdown
  std::optional<double> path_m;
  std::optional<double> terrain_m;
};

// Velocity of the air; points to where the air moves.
struct StoredWind {
  std::optional<double> east_mps;
  std::optional<double> north_mps;
};

// Clearance of the approach path above ground and trees.
struct StoredClearance {
  // Least clearance of the whole path. This value is small, because every final ends at the ground.
  std::optional<double> min_clearance_m;
  // Clearance above the tightest obstacle, and the obstacle's distance to touchdown. Empty if there
  // is no obstacle.
  std::optional<double> obstacle_clearance_m;
  std::optional<double> obstacle_distance_m;
};

struct StoredRejection {
  std::string reason;
  std::string detail;
};

// A site as stored in its row. Absent values are unknown. Names and units as in openapi.yaml.
struct StoredSite {
  std::string id;
  // Empty if unknown. The caller sets this field, because the site's row does not contain it.
  std::string flight_name;
  // "landable", "unverified" or "rejected". Any other verdict counts as rejected.
  std::string verdict = "rejected";
  std::string altitude_datum = "unknown";
  GeoPoint touchdown;
  // Rank among the flight's sites, from 1. RankSites sets it.
  std::optional<int64_t> rank;
  std::optional<std::string> summary;
  std::optional<std::string> reject_reason;
  std::optional<std::string> updated_at;
  std::optional<double> score;
  std::optional<double> grade;
  std::optional<int64_t> num_observations;
  std::optional<int64_t> num_grass_observations;
  std::optional<double> area_m2;
  // Length and width of the usable strip. Empty if the site has no approach.
  std::optional<double> usable_length_m;
  std::optional<double> usable_width_m;
  std::optional<double> hazard_distance_m;
  std::optional<double> slope_deg;
  std::optional<double> roughness_m;
  std::optional<double> unseen_ratio;
  // Length of the free strip: usable_length_m. If that is empty, the least length that the planner
  // required: from the near edge of the touchdown disc to the disc's far edge or to the end of the
  // ground roll, whichever is farther.
  std::optional<double> free_length_m;
  std::optional<double> landing_airspeed_mps;
  std::optional<StoredWind> wind;
  std::optional<StoredClearance> approach;
  std::vector<StoredRejection> rejections;
  std::vector<std::string> warnings;
  // When the ground was last photographed (RFC 3339), and the time since then. The caller sets both
  // fields, because they change after the site is stored.
  std::optional<std::string> last_seen_at;
  std::optional<double> age_s;
  // True if the site's plan fails on a later map. The caller sets this field, because it may change
  // after the site is stored.
  bool is_superseded = false;
  // True if a later map doubts the plan. The caller sets this field, and the verdict.
  bool is_doubted = false;
  // True if the site's flight is an experiment.
  bool is_experiment = false;
  std::optional<FinalPlaces> final_places;
  // Corners of the strip that must be free for the ground roll. Empty if the aircraft needs none.
  std::vector<GeoPoint> ground_roll;
  std::vector<ProfilePoint> profile;
  // Empty if no climb clears the seen ground.
  std::optional<StoredGoAround> go_around;

  bool IsRejected() const { return verdict != "landable" && verdict != "unverified"; }
  // The name shown to people: the flight's name and the rank, with a mark if the site is of an
  // experiment, superseded or not landable. Example: "north field 2 UNVERIFIED". If the flight's
  // name or the rank is unknown, returns the id.
  std::string Name() const;
};
// `feature_json` is the site's GeoJSON feature. `approach_json` is the FeatureCollection of the
// approach; it is empty if the site has no approach. Throws std::exception on text that
// SiteFeature and ApproachJson did not write.
StoredSite ReadStoredSite(const std::string& feature_json,
                          const std::string& approach_json,
                          const std::string& altitude_datum);
// Sorts best first, in the order of RankedSites, and sets each rank.
std::vector<StoredSite> RankSites(std::vector<StoredSite> sites);

// When the ground of a stored site or map was last photographed.
template <typename Row>
CaptureTime SeenOf(const Row& row) {
  const int64_t open_us = std::numeric_limits<int64_t>::max();
  const int64_t until_us = row.seen_until_us.value_or(row.seen_at_us > 0 ? 0 : open_us);
  return {row.seen_at_us, std::max(row.seen_at_us, until_us)};
}

// --- The map around a site ---

// The part of a flight's map around one site. It is drawn and used for new plans.
using SiteMap = AssessedMap;
// Thrown if the stored bytes differ from the bytes that were written.
class DamagedMap : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace freelsd
