#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/legs/legs.h"
#include "api/geojson.h"

namespace freelsd {
namespace {

nlohmann::json LookedPlaceJson(const LookedPlace& place,
                               const std::vector<LookSiteName>& sites,
                               const LocalFrame& local_frame) {
  nlohmann::json object = PlaceJson(place.touchdown_in_world, local_frame);
  object["site_id"] = nullptr;
  object["verdict"] = nullptr;
  if (place.site) {
    object["site_id"] = sites.at(*place.site).site_id;
    object["verdict"] = sites.at(*place.site).verdict;
  }
  object["expected_gain"] = Rounded(place.expected_gain);
  return object;
}

nlohmann::json LegFeature(const LookLeg& leg,
                          int64_t rank,
                          const std::vector<LookSiteName>& sites,
                          const LocalFrame& local_frame) {
  nlohmann::json places = nlohmann::json::array();
  for (const LookedPlace& place : leg.places) {
    places.push_back(LookedPlaceJson(place, sites, local_frame));
  }
  return Feature(LineGeometry({leg.from_in_world, leg.to_in_world}, local_frame),
                 {{"kind", "look"},
                  {"rank", rank},
                  {"heading_deg", Rounded(DegFromRad(leg.heading))},
                  {"altitude_m", Rounded(AltitudeOf(leg.from_in_world, local_frame))},
                  {"length_m", Rounded((leg.to_in_world - leg.from_in_world).norm())},
                  {"transit_m", Rounded(leg.transit_m)},
                  {"expected_gain", Rounded(leg.expected_gain)},
                  {"places", places}});
}

}  // namespace

nlohmann::json LegsJson(const NextLook& look,
                        const std::vector<LookSiteName>& sites,
                        const FlightContext& context) {
  std::vector<nlohmann::json> features;
  int64_t rank = 0;
  for (const LookLeg& leg : look.legs) {
    features.push_back(LegFeature(leg, ++rank, sites, context.local_frame));
  }
  nlohmann::json collection = FeatureCollection(features);
  collection["flight_id"] = context.flight_id;
  collection["altitude_datum"] = context.altitude_datum;
  collection["landing_value"] = Rounded(look.landing_value);
  collection["expected_gain"] = Rounded(look.expected_gain);
  collection["height_above_ground_m"] = Rounded(look.height_above_ground_m);
  collection["photo_spacing_m"] = Rounded(look.photo_spacing_m);
  collection["photo_along_m"] = Rounded(look.photo_extent_m.x());
  collection["photo_across_m"] = Rounded(look.photo_extent_m.y());
  collection["turn_radius_m"] = Rounded(look.turn_radius_m);
  return collection;
}

}  // namespace freelsd
