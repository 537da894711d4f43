#include <algorithm>
#include <cmath>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/export/geojson/geojson.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Longitude, latitude, and what else the position has.
using Position = std::vector<double>;
using Positions = std::vector<Position>;
// The outer ring comes first.
using Rings = std::vector<Positions>;

constexpr double kCutDeg = 180.0;
constexpr double kTurnDeg = 360.0;
// Steps per unit of an interpolated number.
constexpr double kSteps = 1e9;

double RoundedNumber(double number) { return std::round(number * kSteps) / kSteps; }

bool IsAcross(double from_deg, double to_deg) { return std::abs(to_deg - from_deg) > kCutDeg; }

// Longitudes that go on beyond 180 degrees begin anew at the other side.
void Wrap(nlohmann::json& coordinates) {
  if (coordinates.empty()) return;
  if (coordinates[0].is_array()) {
    for (nlohmann::json& each : coordinates) Wrap(each);
  } else if (std::abs(coordinates[0].get<double>()) > kCutDeg) {
    coordinates[0] = RoundedNumber(std::remainder(coordinates[0].get<double>(), kTurnDeg));
  }
}

// Whether a leg of a line, or of several, is one across.
bool HasLegAcross(const nlohmann::json& coordinates) {
  if (coordinates.empty() || !coordinates[0].is_array()) return false;
  if (coordinates[0].empty() || coordinates[0][0].is_array()) {
    return std::any_of(coordinates.begin(), coordinates.end(), HasLegAcross);
  }
  for (size_t i = 1; i < coordinates.size(); ++i) {
    if (IsAcross(coordinates[i - 1][0], coordinates[i][0])) return true;
  }
  return false;
}

// The place on the leg at the longitude `at_deg`; the leg's longitudes go on beyond 180 degrees.
Position OnLeg(const Position& from, const Position& to, double at_deg) {
  const double way_deg = to[0] - from[0];
  const double share = way_deg == 0.0 ? 0.0 : (at_deg - from[0]) / way_deg;
  Position place(std::min(from.size(), to.size()));
  for (size_t i = 0; i < place.size(); ++i) {
    place[i] = RoundedNumber(from[i] + share * (to[i] - from[i]));
  }
  place[0] = at_deg;
  return place;
}

void Append(const Position& place, Positions& line) {
  if (line.empty() || line.back() != place) line.push_back(place);
}

// --- Lines ---

std::vector<Positions> CutLine(const Positions& line) {
  std::vector<Positions> parts{{line.front()}};
  for (size_t i = 1; i < line.size(); ++i) {
    if (IsAcross(line[i - 1][0], line[i][0])) {
      const double side_deg = std::copysign(kCutDeg, line[i - 1][0]);
      Position beyond = line[i];
      beyond[0] += 2.0 * side_deg;
      Position end = OnLeg(line[i - 1], beyond, side_deg);
      Append(end, parts.back());
      end[0] = -side_deg;
      parts.push_back({end});
    }
    Append(line[i], parts.back());
  }
  // A line that begins or ends on the antimeridian.
  std::erase_if(parts, [](const Positions& part) { return part.size() < 2; });
  return parts;
}

// --- Polygons ---

Polygon PlaneOf(const Positions& ring) {
  Polygon plane;
  for (const Position& place : ring) plane.emplace_back(place[0], place[1]);
  return plane;
}

// An open ring whose longitudes go on beyond 180 degrees, from that of its first position.
Positions Unrolled(Positions ring) {
  for (size_t i = 1; i < ring.size(); ++i) {
    ring[i][0] = ring[i - 1][0] + std::remainder(ring[i][0] - ring[i - 1][0], kTurnDeg);
  }
  return ring;
}

// Part of a ring on the near side of the cut. Both ends are on the cut.
using Chain = Positions;

// Appends what of the ring is near; a ring that is near as a whole to `whole`.
void Clip(const Positions& ring, std::vector<Chain>& chains, Rings& whole) {
  const auto is_near = [](const Position& place) { return place[0] <= kCutDeg; };
  const auto far = std::find_if_not(ring.begin(), ring.end(), is_near);
  if (far == ring.end()) {
    whole.push_back(ring);
    return;
  }
  const size_t first = static_cast<size_t>(far - ring.begin());
  for (size_t i = 1; i <= ring.size(); ++i) {
    const Position& from = ring[(first + i - 1) % ring.size()];
    const Position& to = ring[(first + i) % ring.size()];
    if (!is_near(from) && is_near(to)) chains.push_back({OnLeg(from, to, kCutDeg)});
    if (is_near(to)) Append(to, chains.back());
    if (is_near(from) && !is_near(to)) Append(OnLeg(from, to, kCutDeg), chains.back());
  }
}

// Closes chains along the cut. With the inside on the left of each chain, the boundary goes north
// from a chain's end to the next chain's beginning.
Rings Closed(std::vector<Chain> chains) {
  // One that only touches the cut.
  std::erase_if(chains, [](const Chain& chain) {
    return std::all_of(chain.begin(), chain.end(), [](const auto& at) { return at[0] == kCutDeg; });
  });
  Rings rings;
  std::vector<bool> is_used(chains.size(), false);
  for (size_t start = 0; start < chains.size(); ++start) {
    if (is_used[start]) continue;
    Positions ring;
    for (size_t at = start; !is_used[at];) {
      is_used[at] = true;
      for (const Position& place : chains[at]) Append(place, ring);
      const double end_deg = chains[at].back()[1];
      size_t next = start;
      for (size_t i = 0; i < chains.size(); ++i) {
        const double begin_deg = chains[i].front()[1];
        if (begin_deg < end_deg || (is_used[i] && i != start)) continue;
        const double best_deg = chains[next].front()[1];
        if (best_deg < end_deg || begin_deg < best_deg) next = i;
      }
      at = next;
    }
    rings.push_back(std::move(ring));
  }
  return rings;
}

// What of the polygon is on the near side. Open rings; the outer one is counter-clockwise.
std::vector<Rings> Near(const Rings& polygon) {
  std::vector<Chain> chains;
  Rings whole;
  for (const Positions& ring : polygon) Clip(ring, chains, whole);
  std::vector<Rings> parts;
  for (Positions& ring : Closed(std::move(chains))) parts.push_back({std::move(ring)});
  for (const Positions& ring : whole) {
    if (SignedArea(PlaneOf(ring)) > 0.0) parts.push_back({ring});
  }
  for (const Positions& ring : whole) {
    if (SignedArea(PlaneOf(ring)) > 0.0) continue;
    for (Rings& part : parts) {
      if (!Contains(PlaneOf(part.front()), {ring.front()[0], ring.front()[1]})) continue;
      part.push_back(ring);
      break;
    }
  }
  return parts;
}

// The other side, as a mirror shows it: the far side becomes the near one, and back.
Rings Mirrored(Rings polygon) {
  for (Positions& ring : polygon) {
    for (Position& place : ring) place[0] = kTurnDeg - place[0];
    std::reverse(ring.begin(), ring.end());
  }
  return polygon;
}

// Near the outer ring, with its inside on the left; holes the other way round.
void Align(Rings& polygon) {
  for (size_t i = 0; i < polygon.size(); ++i) {
    const double turns = std::round((polygon[0][0][0] - polygon[i][0][0]) / kTurnDeg);
    for (Position& place : polygon[i]) place[0] += kTurnDeg * turns;
    const bool is_left = SignedArea(PlaneOf(polygon[i])) > 0.0;
    if (is_left != (i == 0)) std::reverse(polygon[i].begin(), polygon[i].end());
  }
}

// Nothing if the polygon is around a pole.
std::vector<Rings> CutPolygon(Rings polygon) {
  double west_deg = kTurnDeg;
  for (Positions& ring : polygon) {
    ring.pop_back();
    ring = Unrolled(std::move(ring));
    if (IsAcross(ring.front()[0], ring.back()[0])) return {};
    for (const Position& place : ring) west_deg = std::min(west_deg, place[0]);
  }
  if (west_deg < -kCutDeg) {
    for (Positions& ring : polygon) {
      for (Position& place : ring) place[0] += kTurnDeg;
    }
  }
  Align(polygon);
  std::vector<Rings> parts = Near(polygon);
  for (Rings& part : Near(Mirrored(polygon))) {
    Rings far = Mirrored(std::move(part));
    for (Positions& ring : far) {
      for (Position& place : ring) place[0] -= kTurnDeg;
    }
    parts.push_back(std::move(far));
  }
  for (Rings& part : parts) {
    for (Positions& ring : part) ring.push_back(ring.front());
  }
  return parts;
}

// --- Geometries ---

nlohmann::json Multi(const char* type, nlohmann::json coordinates) {
  return {{"type", type}, {"coordinates", std::move(coordinates)}};
}

nlohmann::json CutLines(const nlohmann::json& geometry) {
  std::vector<Positions> parts = CutLine(geometry["coordinates"].get<Positions>());
  if (parts.size() == 1) return Multi("LineString", parts.front());
  return Multi("MultiLineString", parts);
}

nlohmann::json CutPolygons(const nlohmann::json& geometry) {
  const bool is_one = geometry["type"] == "Polygon";
  std::vector<Rings> parts;
  const nlohmann::json& given = geometry["coordinates"];
  for (const nlohmann::json& polygon : is_one ? nlohmann::json::array({given}) : given) {
    std::vector<Rings> cut;
    if (HasLegAcross(polygon)) cut = CutPolygon(polygon.get<Rings>());
    if (cut.empty()) cut.push_back(polygon.get<Rings>());
    parts.insert(parts.end(), cut.begin(), cut.end());
  }
  if (is_one && parts.size() == 1) return Multi("Polygon", parts.front());
  return Multi("MultiPolygon", parts);
}

nlohmann::json CutGeometry(nlohmann::json geometry) {
  if (!geometry.contains("coordinates")) return geometry;
  Wrap(geometry["coordinates"]);
  if (!HasLegAcross(geometry["coordinates"])) return geometry;
  const std::string type = geometry.value("type", "");
  if (type == "LineString") return CutLines(geometry);
  if (type == "Polygon" || type == "MultiPolygon") return CutPolygons(geometry);
  return geometry;
}

}  // namespace

nlohmann::json CutAtAntimeridian(nlohmann::json geojson) {
  if (!geojson.is_object()) return geojson;
  if (geojson.contains("features")) {
    for (nlohmann::json& feature : geojson["features"]) {
      feature = CutAtAntimeridian(std::move(feature));
    }
  } else if (geojson.contains("geometry")) {
    geojson["geometry"] = CutAtAntimeridian(std::move(geojson["geometry"]));
  } else {
    geojson = CutGeometry(std::move(geojson));
  }
  return geojson;
}

}  // namespace freelsd
