// OpenStreetMap's power lines, towers and masts, as GeoJSON with their tags as properties or below
// "tags" (Overpass turbo, osmtogeojson, QuickOSM, ogr2ogr).
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "api/import/import.h"
#include "api/import/number_text.h"
#include "api/import/obstacles/obstacles.h"
#include "api/import/obstacles/shape.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

// Of lines and points drawn from aerial pictures.
constexpr double kDrawnPositionSdM = 10.0;
constexpr double kFootM = 0.3048;
constexpr double kDegreeM = 111320.0;
constexpr double kMaxTaggedHeightM = 1000.0;
// From this tension on, towers are as high as kHighTensionM.
constexpr double kHighVoltage = 200000.0;
constexpr double kHighTensionM = 80.0;

// Height above ground where it is not tagged: of the high ones of the kind.
struct OsmKind {
  const char* key;
  const char* value;
  double height_m;
};
constexpr std::array kKinds{
    OsmKind{"power", "line", 60.0},
    OsmKind{"power", "minor_line", 15.0},
    OsmKind{"power", "tower", 80.0},
    OsmKind{"power", "pole", 15.0},
    OsmKind{"power", "portal", 30.0},
    OsmKind{"power", "catenary_mast", 12.0},
    OsmKind{"power", "terminal", 15.0},
    OsmKind{"communication", "line", 12.0},
    OsmKind{"telephone", "line", 12.0},
    OsmKind{"aerialway", "*", 60.0},
    OsmKind{"man_made", "mast", 150.0},
    OsmKind{"man_made", "tower", 150.0},
    OsmKind{"man_made", "communications_tower", 350.0},
    OsmKind{"man_made", "chimney", 250.0},
    OsmKind{"man_made", "crane", 100.0},
    OsmKind{"man_made", "utility_pole", 15.0},
    OsmKind{"man_made", "flagpole", 30.0},
    OsmKind{"man_made", "windmill", 40.0},
    OsmKind{"generator:source", "wind", 250.0},
};

std::string TagOf(const nlohmann::json& tags, const char* key) {
  const auto found = tags.find(key);
  if (found == tags.end()) return "";
  if (found->is_string()) return *found;
  return found->is_number() ? found->dump() : "";
}

nlohmann::json TagsOf(const nlohmann::json& feature) {
  if (!feature.is_object() || !feature.contains("properties")) return nlohmann::json::object();
  nlohmann::json properties = feature.at("properties");
  if (!properties.is_object()) return nlohmann::json::object();
  const auto tags = properties.find("tags");
  return tags != properties.end() && tags->is_object() ? *tags : properties;
}

const OsmKind* KindOf(const nlohmann::json& tags) {
  // Below ground there is nothing to hit.
  const std::string location = TagOf(tags, "location");
  if (location == "underground" || location == "underwater") return nullptr;
  for (const OsmKind& kind : kKinds) {
    const std::string value = TagOf(tags, kind.key);
    const bool is_any = std::string_view(kind.value) == "*" && !value.empty() && value != "station";
    if (value == kind.value || is_any) return &kind;
  }
  return nullptr;
}

// "45", "45 m", "148 ft" or "45.5m". Nothing for anything else.
std::optional<double> TaggedHeightM(const nlohmann::json& tags) {
  const std::string text = InLowerCase(TagOf(tags, "height"));
  const size_t end = std::min(text.find_first_not_of("0123456789."), text.size());
  const std::optional<double> number = NumberFromText(std::string_view(text).substr(0, end));
  const std::string_view unit = Trimmed(std::string_view(text).substr(end));
  const bool is_feet = unit == "ft" || unit == "feet" || unit == "'";
  if (!number || !(unit.empty() || unit == "m" || is_feet)) return std::nullopt;
  const double height_m = *number * (is_feet ? kFootM : 1.0);
  return height_m > 0.1 && height_m <= kMaxTaggedHeightM ? std::optional(height_m) : std::nullopt;
}

double HeightM(const OsmKind& kind, const nlohmann::json& tags) {
  if (std::string_view(kind.key) != "power" || std::string_view(kind.value) != "line") {
    return kind.height_m;
  }
  // The highest of several, "380000;110000".
  double volts = 0.0;
  std::string_view rest;
  const std::string text = TagOf(tags, "voltage");
  for (rest = text; !rest.empty();
       rest.remove_prefix(std::min(rest.find(';'), rest.size() - 1) + 1)) {
    volts = std::max(volts, NumberFromText(rest.substr(0, rest.find(';'))).value_or(0.0));
  }
  return volts >= kHighVoltage ? kHighTensionM : kind.height_m;
}

std::optional<GeoPoint> PointOf(const nlohmann::json& value) {
  if (!value.is_array() || value.size() < 2 || !value[0].is_number() || !value[1].is_number()) {
    return std::nullopt;
  }
  const GeoPoint point{value[1], value[0], std::nan("")};
  const bool is_on_earth =
      std::abs(point.latitude_deg) <= 90.0 && std::abs(point.longitude_deg) <= 180.0;
  return is_on_earth ? std::optional(point) : std::nullopt;
}

// Empty if one of the positions is none.
std::vector<GeoPoint> PointsOf(const nlohmann::json& positions) {
  std::vector<GeoPoint> points;
  if (!positions.is_array()) return points;
  for (const nlohmann::json& position : positions) {
    const std::optional<GeoPoint> point = PointOf(position);
    if (!point) return {};
    points.push_back(*point);
  }
  return points;
}

// Lines of a geometry; a point is a line of one, a building its outline.
std::vector<std::vector<GeoPoint>> LinesIn(const nlohmann::json& feature) {
  const nlohmann::json geometry = feature.value("geometry", nlohmann::json());
  if (!geometry.is_object()) return {};
  const std::string type = geometry.value("type", "");
  const nlohmann::json coordinates = geometry.value("coordinates", nlohmann::json());
  std::vector<std::vector<GeoPoint>> lines;
  if (type == "Point") {
    if (const auto point = PointOf(coordinates)) lines.push_back({*point});
  } else if (type == "LineString") {
    lines.push_back(PointsOf(coordinates));
  } else if (coordinates.is_array() && (type == "MultiLineString" || type == "Polygon")) {
    for (const nlohmann::json& line : coordinates) lines.push_back(PointsOf(line));
    if (type == "Polygon") lines.resize(std::min<size_t>(lines.size(), 1));
  }
  std::erase_if(lines, [](const auto& line) { return line.empty(); });
  return lines;
}

std::string IdBase(const nlohmann::json& feature) {
  for (const char* const key : {"id", "@id"}) {
    for (const nlohmann::json* object : {&feature, &feature.at("properties")}) {
      if (!object->is_object()) continue;
      const std::string id = TagOf(*object, key);
      if (id.empty()) continue;
      std::string flat = id.substr(0, 80);
      std::replace(flat.begin(), flat.end(), '/', '-');
      return "osm-" + IdFromFileName(flat);
    }
  }
  return "osm-" + Sha256Hex(feature.dump()).substr(0, 16);
}

class Importer {
 public:
  void Add(const nlohmann::json& feature) {
    const nlohmann::json tags = TagsOf(feature);
    const OsmKind* const kind = KindOf(tags);
    const auto lines = kind == nullptr ? std::vector<std::vector<GeoPoint>>() : LinesIn(feature);
    if (lines.empty()) {
      ++num_left_out_;
      return;
    }
    GivenObstacle made;
    made.height_m = TaggedHeightM(tags);
    if (!made.height_m) {
      made.height_m = HeightM(*kind, tags);
      ++num_assumed_[std::string(kind->key) + "=" + kind->value + ": " +
                     std::to_string(std::lround(*made.height_m)) + " m"];
    }
    made.position_sd_m = kDrawnPositionSdM;
    const std::string name = TagOf(tags, "name");
    if (name.size() <= kLimits.max_name_bytes && !HasControlCharacter(name)) made.name = name;
    const std::string base = IdBase(feature);
    for (const std::vector<GeoPoint>& line : lines) AddLine(made, line, base);
  }

  ImportedObstacles Finish(const nlohmann::json& collection) {
    std::vector<std::string>& warnings = imported_.warnings;
    for (const auto& [kind, num] : num_assumed_) {
      warnings.push_back(std::to_string(num) + " of " + kind +
                         " above ground is assumed, because no height is tagged");
    }
    if (num_left_out_ > 0) {
      warnings.push_back(std::to_string(num_left_out_) +
                         " features are no wire or mast above ground: left out");
    }
    warnings.push_back("positions have a standard deviation of 10 m");
    if (imported_.obstacles.empty()) {
      throw InvalidValue("/features", "features: there is no power line, tower or mast");
    }
    AddArea(collection);
    return std::move(imported_);
  }

 private:
  // Long lines in parts, which share their ends.
  void AddLine(GivenObstacle made, const std::vector<GeoPoint>& line, const std::string& base) {
    made.kind = line.size() < 2 || IsOnePlace(line) ? ObstacleKind::kMast : ObstacleKind::kWire;
    for (const GeoPoint& point : line) {
      west_deg_ = std::min(west_deg_, point.longitude_deg);
      east_deg_ = std::max(east_deg_, point.longitude_deg);
      south_deg_ = std::min(south_deg_, point.latitude_deg);
      north_deg_ = std::max(north_deg_, point.latitude_deg);
    }
    const size_t max_num = kLimits.obstacles.max_num_points;
    for (size_t first = 0; first == 0 || first + 1 < line.size(); first += max_num - 1) {
      const size_t last = std::min(first + max_num, line.size());
      made.points.assign(line.begin() + static_cast<long>(first),
                         line.begin() + static_cast<long>(last));
      if (made.kind == ObstacleKind::kMast) made.points.resize(1);
      const size_t number = ++num_of_id_[base];
      made.id = number == 1 ? base : base + "." + std::to_string(number);
      try {
        imported_.obstacles.push_back(ParseStoredObstacle(ObstacleFeature(made)));
      } catch (const ApiError& error) {
        imported_.warnings.push_back(made.id + " is left out: " + error.what());
      }
      if (made.kind == ObstacleKind::kMast) return;
    }
  }

  void AddArea(const nlohmann::json& collection) {
    const nlohmann::json box = collection.value("bbox", nlohmann::json());
    const bool has_box =
        box.is_array() && (box.size() == 4 || box.size() == 6) &&
        std::all_of(box.begin(), box.end(), [](const auto& each) { return each.is_number(); });
    if (has_box) {
      const size_t half = box.size() / 2;
      west_deg_ = box[0];
      south_deg_ = box[1];
      east_deg_ = box[half];
      north_deg_ = box[half + 1];
    } else {
      imported_.warnings.emplace_back(
          "the collection has no bbox: wires count as known in the box around its features");
    }
    GivenObstacle area;
    area.kind = ObstacleKind::kWiresKnown;
    area.name = "OpenStreetMap";
    area.is_area = true;
    area.points = Outline();
    area.id = "osm-wires-known-" + Sha256Hex(ObstacleFeature(area).dump()).substr(0, 16);
    const bool is_area = west_deg_ < east_deg_ && south_deg_ < north_deg_;
    try {
      if (is_area) imported_.obstacles.push_back(ParseStoredObstacle(ObstacleFeature(area)));
    } catch (const ApiError& error) {
      imported_.warnings.push_back(std::string("the area of known wires is not stored: ") +
                                   error.what());
    }
  }

  // Its corners, and points between where a side is long.
  std::vector<GeoPoint> Outline() const {
    const std::array<GeoPoint, 4> corners{GeoPoint{south_deg_, west_deg_, std::nan("")},
                                          {south_deg_, east_deg_, std::nan("")},
                                          {north_deg_, east_deg_, std::nan("")},
                                          {north_deg_, west_deg_, std::nan("")}};
    std::vector<GeoPoint> outline;
    for (size_t i = 0; i < corners.size(); ++i) {
      const GeoPoint& a = corners.at(i);
      const GeoPoint& b = corners.at((i + 1) % corners.size());
      const double span_deg =
          std::abs(b.latitude_deg - a.latitude_deg) + std::abs(b.longitude_deg - a.longitude_deg);
      const double max_num = 200.0;
      const int num = static_cast<int>(
          std::clamp(std::ceil(span_deg * kDegreeM / kLimits.obstacles.max_leg_m), 1.0, max_num));
      for (int k = 0; k < num; ++k) {
        const double ratio = static_cast<double>(k) / num;
        outline.push_back({a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg),
                           a.longitude_deg + ratio * (b.longitude_deg - a.longitude_deg),
                           std::nan("")});
      }
    }
    return outline;
  }

  double west_deg_ = 180.0, east_deg_ = -180.0, south_deg_ = 90.0, north_deg_ = -90.0;
  size_t num_left_out_ = 0;
  std::map<std::string, size_t> num_assumed_;
  std::map<std::string, size_t> num_of_id_;
  ImportedObstacles imported_;
};

}  // namespace

bool IsOpenStreetMap(const nlohmann::json& feature) {
  const nlohmann::json tags = TagsOf(feature);
  if (tags.contains("kind")) return false;
  return std::any_of(kKinds.begin(), kKinds.end(), [&tags](const OsmKind& kind) {
    return tags.contains(kind.key);
  });
}

ImportedObstacles ImportOpenStreetMap(const nlohmann::json& collection) {
  Importer importer;
  for (const nlohmann::json& feature : collection.at("features")) {
    if (!feature.is_object() || !feature.contains("properties")) continue;
    importer.Add(feature);
  }
  return importer.Finish(collection);
}

}  // namespace freelsd
