// One site in every format is one place, one heading, one circle: tolerances and readers of the
// formats' tests.
#pragma once

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/sites/readers.h"
#include "tests/api/export/sites/sites.h"

namespace freelsd {

inline constexpr double kMaxPlaceErrorM = 0.05;
inline constexpr double kMaxAltitudeErrorM = 0.05;
inline constexpr double kMaxHeadingErrorDeg = 0.1;
inline constexpr double kMaxGlideSlopeErrorDeg = 0.05;
// QGroundControl measures on a sphere: 0.6 % off at the equator, northwards.
inline constexpr double kMaxSphereErrorRatio = 0.006;
// Half a thousandth of a minute, both ways.
inline constexpr double kMaxCupErrorM = 1.32;
inline constexpr int kNumSites = 200;

inline double Number(const std::string& text) { return std::stod(text); }

// The places' altitudes are compared, too.
inline void CheckPlace(const GeoPoint& place, const GeoPoint& truth) {
  CHECK(MetresBetween(place, truth) < kMaxPlaceErrorM);
  CHECK(std::abs(place.altitude_m - truth.altitude_m) < kMaxAltitudeErrorM);
}

inline std::string Export(const std::string& format, const KnownSite& site) {
  return ExportSites(format, {site.stored}, {});
}

// All sites, with ids of their own.
inline std::vector<KnownSite> ManySites() {
  std::vector<KnownSite> sites;
  for (int i = 0; i < kNumSites; ++i) {
    KnownSiteOptions options = SomewhereOnEarth(i);
    options.region_id = i;
    sites.push_back(MakeSite(options));
  }
  return sites;
}

inline std::vector<StoredSite> StoredOf(const std::vector<KnownSite>& sites) {
  std::vector<StoredSite> stored;
  stored.reserve(sites.size());
  for (const KnownSite& site : sites) stored.push_back(site.stored);
  return stored;
}

// Geometry by GDAL as GeoJSON, by the feature's name (or id).
inline std::map<std::string, nlohmann::json> ReadByGdal(const std::string& path,
                                                        const std::string& options,
                                                        const std::string& key) {
  const auto output = OutputOf("ogr2ogr -f GeoJSONSeq /vsistdout/ -lco COORDINATE_PRECISION=10 " +
                               options + " " + path);
  REQUIRE(output.has_value());
  std::map<std::string, nlohmann::json> features;
  std::istringstream lines(*output);
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json feature = nlohmann::json::parse(line);
    // GDAL takes a property "id" that equals the feature's own id for the latter.
    const nlohmann::json& name =
        feature["properties"].contains(key) ? feature["properties"] : feature;
    features[name.at(key)] = feature;
  }
  return features;
}

inline GeoPoint PlaceOf(const nlohmann::json& position) {
  return {position.at(1), position.at(0), position.at(2)};
}

}  // namespace freelsd
