#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/import/import.h"
#include "api/import/number_text.h"
#include "api/import/obstacles/air_values.h"
#include "api/import/obstacles/obstacles.h"
#include "api/import/obstacles/shape.h"
#include "api/import/utf8.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

constexpr double kMetresPerNauticalMile = 1852.0;
constexpr double kMaxRadiusNm = 500.0;
// Of the polygons that stand for circles and arcs.
constexpr double kMaxStepDeg = 5.0;
// Of airspaces whose borders come from charts.
constexpr double kPositionSdM = 50.0;
constexpr size_t kMaxIdBytes = 100;
// Bytes from which the format is recognised.
constexpr size_t kMaxHeadBytes = 4096;

ApiError Problem(size_t line, const std::string& why) {
  const std::string detail = "line " + std::to_string(line) + ": " + why;
  return ApiError("InvalidAirspace", detail, {{"line " + std::to_string(line), why}});
}

[[noreturn]] void Refuse(size_t line, const std::string& why) { throw Problem(line, why); }

struct Airspace {
  size_t line = 0;
  std::string name;
  std::optional<AirAltitude> floor;
  std::optional<AirAltitude> ceiling;
  std::vector<GeoPoint> ring;
  std::optional<GeoPoint> center;
  bool is_clockwise = true;
  // The first reason for which it cannot be used.
  std::optional<ApiError> problem;
};

GeoPoint On(const GeoPoint& center, double radius_m, double bearing_deg) {
  const double bearing = RadFromDeg(bearing_deg);
  const GeoPoint place = LocalFrame(center).GeoFromWorld(
      {radius_m * std::sin(bearing), radius_m * std::cos(bearing), 0.0});
  return {place.latitude_deg, place.longitude_deg, 0.0};
}

// Distance and bearing of a place from the centre.
struct Polar {
  double radius_m = 0.0;
  double bearing_deg = 0.0;
};

Polar PolarOf(const GeoPoint& center, const GeoPoint& place) {
  const Eigen::Vector2d way = LocalFrame(center).WorldFromGeo(place).head<2>();
  return {way.norm(), DegFromRad(std::atan2(way.x(), way.y()))};
}

// Points around the arc, so that its inside is covered.
void AddArc(Airspace& airspace, double radius_m, double from_deg, double sweep_deg) {
  const int num_steps = std::max(1, static_cast<int>(std::ceil(std::abs(sweep_deg) / kMaxStepDeg)));
  const double step_deg = sweep_deg / num_steps;
  const double outside_m = radius_m / std::cos(RadFromDeg(0.5 * step_deg));
  for (int i = 0; i <= num_steps; ++i) {
    airspace.ring.push_back(On(*airspace.center, outside_m, from_deg + i * step_deg));
  }
}

// In (0, 360], in the direction of the arc.
double SweepDeg(double from_deg, double to_deg, bool is_clockwise) {
  double sweep_deg = std::fmod(is_clockwise ? to_deg - from_deg : from_deg - to_deg, 360.0);
  if (sweep_deg <= 0.0) sweep_deg += 360.0;
  return is_clockwise ? sweep_deg : -sweep_deg;
}

std::vector<std::string_view> SplitAtCommas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const size_t comma = text.find(',');
    parts.push_back(Trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

// What one file says, line by line.
class Reader {
 public:
  void Read(size_t line, std::string_view text);
  ImportedObstacles Finish();

 private:
  void ReadRecord(size_t line, const std::string& command, std::string_view value);
  void ReadGeometry(size_t line, const std::string& command, std::string_view value);
  void ReadVariable(size_t line, std::string_view value);
  void ReadArc(size_t line, std::string_view value);
  void ReadArcBetween(size_t line, std::string_view value);
  double RadiusM(size_t line, std::string_view text) const;
  GeoPoint PointOf(size_t line, std::string_view text) const;
  void End();
  void Make(const Airspace& airspace);
  void Add(GivenObstacle made, size_t line);
  void LeaveOut(const Airspace& airspace, const ApiError& problem);
  std::string NewId(const std::string& name);

  std::optional<Airspace> airspace_;
  std::set<std::string> ids_;
  // Unknown commands, and the first line of each.
  std::map<std::string, size_t> unknown_;
  std::optional<ApiError> first_problem_;
  ImportedObstacles imported_;
  // Within the lines of a river or road.
  bool is_terrain_ = false;
};

GeoPoint Reader::PointOf(size_t line, std::string_view text) const {
  const std::optional<GeoPoint> point = CoordinatesFromText(text);
  if (!point) Refuse(line, "must be coordinates as 47:35:24 N 007:31:12 E");
  return *point;
}

double Reader::RadiusM(size_t line, std::string_view text) const {
  const std::optional<double> radius_nm = NumberFromText(text);
  if (!airspace_->center) Refuse(line, "a centre (V X=) is needed before");
  if (!radius_nm || *radius_nm <= 0.0 || *radius_nm > kMaxRadiusNm) {
    Refuse(line, "the radius must be a number of nautical miles in (0, 500]");
  }
  return *radius_nm * kMetresPerNauticalMile;
}

void Reader::ReadVariable(size_t line, std::string_view value) {
  const size_t equals = value.find('=');
  const std::string_view name = Trimmed(value.substr(0, equals));
  const std::string_view content =
      equals == std::string_view::npos ? std::string_view() : Trimmed(value.substr(equals + 1));
  if (name == "X" || name == "x") {
    airspace_->center = PointOf(line, content);
  } else if (name == "D" || name == "d") {
    if (content != "+" && content != "-") Refuse(line, "D must be + or -");
    airspace_->is_clockwise = content == "+";
  }
  // Z (zoom) and W (width of an airway) do not change a place.
}

void Reader::ReadArc(size_t line, std::string_view value) {
  const std::vector<std::string_view> parts = SplitAtCommas(value);
  if (parts.size() != 3) Refuse(line, "DA must have radius, start and end");
  const double radius_m = RadiusM(line, parts[0]);
  const std::optional<double> from_deg = NumberFromText(parts[1]),
                              to_deg = NumberFromText(parts[2]);
  const auto is_angle = [](const std::optional<double>& angle_deg) {
    return angle_deg && std::abs(*angle_deg) <= 360.0;
  };
  if (!is_angle(from_deg) || !is_angle(to_deg)) Refuse(line, "start and end must be degrees");
  AddArc(*airspace_, radius_m, *from_deg, SweepDeg(*from_deg, *to_deg, airspace_->is_clockwise));
}

void Reader::ReadArcBetween(size_t line, std::string_view value) {
  const std::vector<std::string_view> parts = SplitAtCommas(value);
  if (parts.size() != 2) Refuse(line, "DB must have two coordinates");
  if (!airspace_->center) Refuse(line, "a centre (V X=) is needed before");
  const Polar from = PolarOf(*airspace_->center, PointOf(line, parts[0]));
  const Polar to = PolarOf(*airspace_->center, PointOf(line, parts[1]));
  const double radius_m = std::max(from.radius_m, to.radius_m);
  if (radius_m <= 0.0 || radius_m > kMaxRadiusNm * kMetresPerNauticalMile) {
    Refuse(line, "the arc must be within 500 nautical miles of its centre");
  }
  AddArc(*airspace_,
         radius_m,
         from.bearing_deg,
         SweepDeg(from.bearing_deg, to.bearing_deg, airspace_->is_clockwise));
}

void Reader::ReadGeometry(size_t line, const std::string& command, std::string_view value) {
  if (command == "DP") {
    airspace_->ring.push_back(PointOf(line, value));
  } else if (command == "V") {
    ReadVariable(line, value);
  } else if (command == "DA") {
    ReadArc(line, value);
  } else if (command == "DB") {
    ReadArcBetween(line, value);
  } else if (command == "DC") {
    AddArc(*airspace_, RadiusM(line, value), 0.0, 360.0);
  } else if (command.starts_with("D")) {
    Refuse(line, "a border by " + ShownPath(command.substr(0, 8)) + " is not supported");
  } else {
    unknown_.emplace(ShownPath(command.substr(0, 8)), line);
  }
  if (airspace_->ring.size() > kLimits.obstacles.max_num_points) {
    Refuse(line,
           "at most " + std::to_string(kLimits.obstacles.max_num_points) +
               " points of an airspace are allowed");
  }
}

std::string Reader::NewId(const std::string& name) {
  std::string word = name.substr(0, kMaxIdBytes);
  std::replace(word.begin(), word.end(), '/', '_');
  const std::string base = "airspace-" + IdFromFileName(word);
  std::string id = base;
  for (int number = 2; !ids_.insert(id).second; ++number) {
    id = base + "-" + std::to_string(number);
  }
  return id;
}

void Reader::LeaveOut(const Airspace& airspace, const ApiError& problem) {
  if (!first_problem_) first_problem_ = problem;
  const std::string name = airspace.name.empty()
                               ? "the airspace of line " + std::to_string(airspace.line)
                               : airspace.name;
  imported_.warnings.push_back(name + " is left out: " + problem.what());
}

void Reader::Add(GivenObstacle made, size_t line) {
  made.id = NewId(made.name);
  if (CrossesItself(made.points)) {
    imported_.warnings.push_back(made.id + ": its border crosses itself");
  }
  imported_.obstacles.push_back(ParseStoredObstacle(ObstacleFeature(made)));
  if (imported_.obstacles.size() <= kLimits.obstacles.max_num_stored) return;
  Refuse(line,
         "at most " + std::to_string(kLimits.obstacles.max_num_stored) + " airspaces are allowed");
}

void Reader::Make(const Airspace& airspace) {
  using Kind = AirAltitude::Kind;
  if (airspace.problem) throw *airspace.problem;
  if (!airspace.floor) Refuse(airspace.line, "AL (the floor) is missing");
  if (!airspace.ceiling) Refuse(airspace.line, "AH (the ceiling) is missing");
  if (IsFlat(airspace.ring)) {
    Refuse(airspace.line, "at least three points that are not on one line are needed");
  }
  if (airspace.floor->kind == Kind::kUnlimited)
    Refuse(airspace.line, "AL (the floor) is no height");
  if (airspace.ceiling->kind == Kind::kGround)
    Refuse(airspace.line, "AH (the ceiling) is the ground");
  GivenObstacle made;
  made.kind = ObstacleKind::kNoFly;
  made.name = airspace.name;
  made.altitude_datum = "amsl";
  made.position_sd_m = kPositionSdM;
  made.is_area = true;
  const auto set = [](const AirAltitude& from, auto& above_sea_m, auto& above_ground_m) {
    if (from.kind == Kind::kAboveSea) above_sea_m = from.altitude_m;
    if (from.kind == Kind::kAboveGround) above_ground_m = from.altitude_m;
  };
  set(*airspace.floor, made.floor_m, made.floor_above_ground_m);
  set(*airspace.ceiling, made.ceiling_m, made.ceiling_above_ground_m);
  for (std::vector<GeoPoint>& ring : CutAtAntimeridian(airspace.ring)) {
    GivenObstacle part = made;
    part.points = std::move(ring);
    if (part.points.size() > 1 &&
        part.points.front().latitude_deg == part.points.back().latitude_deg &&
        part.points.front().longitude_deg == part.points.back().longitude_deg) {
      part.points.pop_back();
    }
    for (GeoPoint& point : part.points) point.altitude_m = std::nan("");
    Add(std::move(part), airspace.line);
  }
}

void Reader::End() {
  if (!airspace_) return;
  const Airspace airspace = *std::exchange(airspace_, std::nullopt);
  const size_t num_before = imported_.obstacles.size();
  try {
    Make(airspace);
  } catch (const ApiError& error) {
    if (imported_.obstacles.size() > kLimits.obstacles.max_num_stored) throw;
    imported_.obstacles.resize(num_before);
    const bool has_line = std::string_view(error.what()).starts_with("line ");
    LeaveOut(airspace, has_line ? error : Problem(airspace.line, error.what()));
  }
}

void Reader::Read(size_t line, std::string_view text) {
  const size_t comment = text.find('*');
  text = Trimmed(text.substr(0, comment));
  if (text.empty()) return;
  const size_t blank = text.find_first_of(" \t=");
  const std::string written(text.substr(0, blank));
  std::string command = written;
  std::transform(command.begin(), command.end(), command.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  const std::string_view value =
      blank == std::string_view::npos ? std::string_view() : Trimmed(text.substr(blank));
  // Lines of terrain begin as airspaces do, and end the one before.
  if (command == "AC" || command == "TO" || command == "TC") End();
  is_terrain_ = command == "TO" || command == "TC" || (is_terrain_ && command != "AC");
  if (command == "AC") {
    airspace_.emplace();
    airspace_->line = line;
    return;
  }
  // Labels, frequencies, times and colours.
  static const std::set<std::string> kIgnored{
      "AT", "AY", "AI", "AF", "AG", "AR", "AW", "AX", "AA", "SP", "SB"};
  if (is_terrain_ || kIgnored.contains(command)) return;
  if (!airspace_) {
    if (!first_problem_) first_problem_ = Problem(line, "an airspace must begin with AC");
    unknown_.emplace(ShownPath(written.substr(0, 8)), line);
    return;
  }
  try {
    ReadRecord(line, command, value);
  } catch (const ApiError& error) {
    if (!airspace_->problem) airspace_->problem = error;
  }
}

void Reader::ReadRecord(size_t line, const std::string& command, std::string_view value) {
  if (command == "AN") {
    if (HasControlCharacter(value)) Refuse(line, "the name has a control character");
    airspace_->name = ShownPath(std::string(value.substr(0, kMaxIdBytes)));
  } else if (command == "AL" || command == "AH") {
    const std::optional<AirAltitude> altitude = AirAltitudeFromText(value);
    if (!altitude) {
      Refuse(line,
             command + " must be an altitude as 4500 FT MSL, FL 95 (at most FL 999), GND or UNL");
    }
    (command == "AL" ? airspace_->floor : airspace_->ceiling) = altitude;
  } else {
    ReadGeometry(line, command, value);
  }
}

ImportedObstacles Reader::Finish() {
  End();
  if (imported_.obstacles.empty()) {
    throw first_problem_ ? *first_problem_ : Problem(1, "there is no airspace");
  }
  for (const auto& [command, line] : unknown_) {
    imported_.warnings.push_back("line " + std::to_string(line) + ": the record " + command +
                                 " is not read");
  }
  return std::move(imported_);
}

}  // namespace

bool IsOpenAir(std::string_view text) {
  const std::string begin = InLowerCase(ToUtf8(text.substr(0, kMaxHeadBytes)));
  const std::string_view first = Trimmed(begin);
  return first.starts_with("*") || first.starts_with("ac ") || first.starts_with("ac\t");
}

ImportedObstacles ParseOpenAir(std::string_view text) {
  if (text.size() > kLimits.obstacles.max_import_bytes) {
    ApiError error("BodyTooLarge", "the airspace file is too large");
    error.limit = static_cast<double>(kLimits.obstacles.max_import_bytes);
    error.observed = static_cast<double>(text.size());
    throw error;
  }
  std::string utf8 = ToUtf8(text);
  // Some programs end lines with it alone.
  if (utf8.find('\n') == std::string::npos) std::replace(utf8.begin(), utf8.end(), '\r', '\n');
  text = utf8;
  Reader reader;
  for (size_t line = 1; !text.empty(); ++line) {
    const size_t end = text.find('\n');
    reader.Read(line, text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return reader.Finish();
}

}  // namespace freelsd
