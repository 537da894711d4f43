// "QGC WPL 110" for Mission Planner, MAVProxy and QGroundControl, with a landing sequence per
// site. No form of comment is accepted by all three.
#include <initializer_list>

#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

// MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_RELATIVE_ALT.
constexpr int kAboveSeaLevel = 0;
constexpr int kAboveHome = 3;
// MAV_CMD.
constexpr int kWaypoint = 16;
constexpr int kLand = 21;
constexpr int kLoiterToAltitude = 31;
constexpr int kDoLandStart = 189;

struct Item {
  int frame;
  int command;
  double parameters[4];
  GeoPoint place;
  double altitude_m;
};

std::string Line(int index, const Item& item) {
  std::string line = std::to_string(index) + (index == 0 ? "\t1\t" : "\t0\t") +
                     std::to_string(item.frame) + "\t" + std::to_string(item.command);
  for (const double parameter : item.parameters) line += "\t" + FixedText(parameter, 3);
  return line + "\t" + FixedText(item.place.latitude_deg, 9) + "\t" +
         FixedText(item.place.longitude_deg, 9) + "\t" + FixedText(item.altitude_m, 3) + "\t1\n";
}

// Leaves the circle on the tangent towards the touchdown.
std::vector<Item> LandingItems(const StoredSite& site, const AltitudeFrame& frame) {
  const FinalPlaces& places = *site.final_places;
  const int number = frame.is_above_home ? kAboveHome : kAboveSeaLevel;
  const double radius_m = places.loiter_radius_m * (places.is_right_turn ? 1.0 : -1.0);
  const double loiter_altitude_m = frame.Of(places.start.altitude_m);
  return {{number, kDoLandStart, {0, 0, 0, 0}, places.loiter_center, loiter_altitude_m},
          {number,
           kLoiterToAltitude,
           {1.0, radius_m, 0.0, 1.0},
           places.loiter_center,
           loiter_altitude_m},
          {number, kLand, {0, 0, 0, 0}, site.touchdown, frame.Of(site.touchdown.altitude_m)}};
}

}  // namespace

std::string WaypointFile(const std::vector<StoredSite>& sites, const ExportOptions& options) {
  const std::vector<StoredSite> safe = SafeSites(sites, true);
  const AltitudeFrame frame = FrameOf(safe, options);
  const StoredSite& best = safe.front();
  // Line 0 is home. The vehicle uses its own home and ignores this line.
  const double home_altitude_m = options.home_altitude_m.value_or(best.touchdown.altitude_m);
  std::string text =
      "QGC WPL 110\n" +
      Line(0, {kAboveSeaLevel, kWaypoint, {0, 0, 0, 0}, best.touchdown, home_altitude_m});
  int index = 1;
  for (const StoredSite& site : safe) {
    for (const Item& item : LandingItems(site, frame)) text += Line(index++, item);
  }
  return text;
}

}  // namespace freelsd
