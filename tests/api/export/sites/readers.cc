#include "tests/api/export/sites/readers.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>
#include <doctest/doctest.h>
#include <unistd.h>

namespace freelsd {
namespace {

constexpr double kEarthRadiusM = 6371007.2;

struct Polar {
  double distance_m;
  double azimuth_deg;
};

Eigen::Vector3d OnUnitSphere(const GeoPoint& place) {
  const double latitude = RadFromDeg(place.latitude_deg);
  const double longitude = RadFromDeg(place.longitude_deg);
  return {std::cos(latitude) * std::cos(longitude),
          std::cos(latitude) * std::sin(longitude),
          std::sin(latitude)};
}

// By vectors, not by the formulas of the writer.
Polar OnSphere(const GeoPoint& from, const GeoPoint& to) {
  const Eigen::Vector3d up = OnUnitSphere(from), target = OnUnitSphere(to);
  const Eigen::Vector3d east = Eigen::Vector3d::UnitZ().cross(up).normalized();
  const Eigen::Vector3d north = up.cross(east);
  return {kEarthRadiusM * std::atan2(up.cross(target).norm(), up.dot(target)),
          DegFromRad(std::atan2(target.dot(east), target.dot(north)))};
}

GeoPoint PlaceOf(const nlohmann::json& coordinate) {
  return {coordinate.at(0), coordinate.at(1), coordinate.at(2)};
}

}  // namespace

bool IsInstalled(const std::string& program) {
  return OutputOf("command -v " + program).has_value();
}

TemporaryFile::TemporaryFile(const std::string& name, const std::string& bytes)
    : path_(std::filesystem::temp_directory_path() /
            ("freelsd_" + std::to_string(getpid()) + "_" + name)) {
  std::ofstream(path_, std::ios::binary) << bytes;
}

TemporaryFile::~TemporaryFile() { std::filesystem::remove(path_); }

std::optional<std::string> OutputOf(const std::string& command) {
  FILE* const pipe = popen((command + " 2>/dev/null").c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string output;
  std::array<char, 4096> buffer;
  while (const size_t count = fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.append(buffer.data(), count);
  }
  if (pclose(pipe) != 0) return std::nullopt;
  return output;
}

double MetresBetween(const GeoPoint& a, const GeoPoint& b) {
  double distance_m;
  GeographicLib::Geodesic::WGS84().Inverse(
      a.latitude_deg, a.longitude_deg, b.latitude_deg, b.longitude_deg, distance_m);
  return distance_m;
}

double MetresInSpace(const GeoPoint& a, const GeoPoint& b) {
  const auto in_space = [](const GeoPoint& place) {
    Eigen::Vector3d point;
    GeographicLib::Geocentric::WGS84().Forward(
        place.latitude_deg, place.longitude_deg, place.altitude_m, point.x(), point.y(), point.z());
    return point;
  };
  return (in_space(a) - in_space(b)).norm();
}

double DegreesBetween(double a_deg, double b_deg) {
  return std::abs(std::remainder(a_deg - b_deg, 360.0));
}

LandingPattern ReadPlan(const std::string& plan) {
  const nlohmann::json item = nlohmann::json::parse(plan).at("mission").at("items").at(0);
  REQUIRE(item.at("type") == "ComplexItem");
  REQUIRE(item.at("complexItemType") == "fwLandingPattern");
  REQUIRE(item.at("version") == 2);
  REQUIRE(item.at("altitudesAreRelative").is_boolean());
  REQUIRE(item.at("valueSetIsDistance").is_boolean());
  LandingPattern pattern;
  pattern.land = PlaceOf(item.at("landCoordinate"));
  pattern.loiter_center = PlaceOf(item.at("landingApproachCoordinate"));
  pattern.loiter_radius_m = item.at("loiterRadius");
  pattern.is_clockwise = item.at("loiterClockwise");
  const Polar center = OnSphere(pattern.land, pattern.loiter_center);
  REQUIRE(center.distance_m > pattern.loiter_radius_m);
  const double to_tangent_deg = DegFromRad(std::asin(pattern.loiter_radius_m / center.distance_m));
  pattern.distance_m = std::sqrt(center.distance_m * center.distance_m -
                                 pattern.loiter_radius_m * pattern.loiter_radius_m);
  pattern.heading_deg =
      center.azimuth_deg + (pattern.is_clockwise ? to_tangent_deg : -to_tangent_deg) + 180.0;
  pattern.glide_slope_deg = DegFromRad(
      std::atan2(pattern.loiter_center.altitude_m - pattern.land.altitude_m, pattern.distance_m));
  return pattern;
}

std::vector<std::vector<std::string>> SplitRows(const std::string& text, char separator) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    std::vector<std::string> cells(1);
    bool is_quoted = false;
    for (const char c : line) {
      if (c == '"') {
        is_quoted = !is_quoted;
      } else if (c == separator && !is_quoted) {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    rows.push_back(cells);
  }
  return rows;
}

}  // namespace freelsd
