// One field as flights at different times find it: small maps made by hand, and sites whose stored
// plan lies on it, without the engine's photogrammetry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/stored/stored.h"
#include "server/recall/superseding.h"
#include "tests/server/meadow.h"

namespace freelsd {

enum class Ground {
  kFree,
  kHazardInDisc,  // no grass is recognised 7 m from the touchdown; the heights are as before
  kSlope,         // 6 degrees in the disc, by the slopes alone: too steep for the strict aircraft
  kTreeOnFinal,
  kTreeOnCircle,
  kTreeAside,  // below no part of the plan
  kDiscUnseen,
  kDiscUnseenTree,  // and a tree on the final
  kHazardAside      // no grass is recognised 26 m from the touchdown, outside the disc
};

// What a flight says of the field.
struct Flown {
  std::string flight_id = "f";
  // When it photographed the field.
  int64_t seen_at_us = 0;
  Ground ground = Ground::kFree;
  bool is_strict = false;
  // With less clearance than every profile.
  bool is_loose = false;
  // With memory "none".
  bool is_experiment = false;
  bool is_accepted = true;
  // Which field: 4 km north of the one before.
  int place = 0;
  int64_t updated_at_us = 1;
  int region_id = 1;
  std::string altitude_datum = "unknown";
  // Of the map above the same ground of other flights.
  double altitude_error_m = 0.0;
  // Half a side of the map; the plan lies within 100 m of the touchdown.
  double half_size_m = 100.0;
  // Half a side of the region's rectangle.
  double half_region_m = 20.0;
  double latitude_deg = 47.0;
  double longitude_deg = 8.0;
  double approach_height_m = 10.0;
  double tree_m = 15.0;
  // As in SiteRow.
  std::optional<int64_t> seen_until_us = std::nullopt;
  // Where the wind of the plan blows to; the landing is against it.
  Eigen::Vector2d wind{0.0, -4.0};
  // From the touchdown to the middle of the map; the ground's features move with it.
  Eigen::Vector2d map_shift{0.0, 0.0};
};

std::string IdOf(const Flown& flown);
GeoPoint TouchdownOf(const Flown& flown);
inline GeoPoint TouchdownOf(int place) { return TouchdownOf(Flown{.place = place}); }
FlightRequest RequestOf(const Flown& flown);
// The flight itself, without its site.
FlightRow FlightOf(const Flown& flown);
// A site whose plan is landed against the wind on the middle of the field: northwards, if nothing
// else is given. The plan does not depend on the ground.
SiteRow SiteOf(const Flown& flown);
// 40 x 40 cells on the default size, about an origin that differs from flight to flight.
SiteMap MapOf(const Flown& flown);
// As the server stores it: in place of what the flight has said of the field so far.
void Store(Storage& storage, MapCache& maps, const Flown& flown);

// The meadow's server, which has stored in this order what the flights said.
struct FlownServer : MeadowServer {
  explicit FlownServer(const std::vector<Flown>& flights);

  // Its properties.
  nlohmann::json Site(const std::string& id) const;
};

}  // namespace freelsd
