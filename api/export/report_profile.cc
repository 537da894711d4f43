#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/report.h"

namespace freelsd {
namespace {

constexpr double kWidth = 800.0, kHeight = 300.0;
constexpr double kLeft = 60.0, kRight = 780.0, kTop = 20.0, kBottom = 260.0;

// Altitudes along the final; the start is on the left, the touchdown on the right.
struct Scales {
  double longest_m = 1.0;
  double lowest_m = std::numeric_limits<double>::infinity();
  double highest_m = -std::numeric_limits<double>::infinity();

  double X(double distance_m) const { return kRight - (kRight - kLeft) * distance_m / longest_m; }
  double Y(double altitude_m) const {
    return kBottom - (kBottom - kTop) * (altitude_m - lowest_m) / (highest_m - lowest_m);
  }
};

Scales ScalesOf(const nlohmann::json& profile) {
  Scales scales;
  for (const nlohmann::json& distance : profile.at("distance_m")) {
    scales.longest_m = std::max(scales.longest_m, distance.get<double>());
  }
  for (const char* const name : {"path_m", "terrain_m"}) {
    for (const nlohmann::json& altitude : profile.at(name)) {
      if (altitude.is_null()) continue;
      scales.lowest_m = std::min(scales.lowest_m, altitude.get<double>());
      scales.highest_m = std::max(scales.highest_m, altitude.get<double>());
    }
  }
  // Level ground is a line at the bottom, and nothing is divided by zero.
  scales.lowest_m -= 1.0;
  scales.highest_m += 1.0;
  return scales;
}

std::string Number(double number) { return FixedText(number, 1); }

// Broken where a value is null.
std::string Path(const nlohmann::json& profile,
                 const char* name,
                 const char* css_class,
                 const Scales& scales) {
  std::string commands;
  bool is_drawing = false;
  for (size_t i = 0; i < profile.at(name).size(); ++i) {
    const nlohmann::json& altitude = profile.at(name)[i];
    if (!altitude.is_null()) {
      commands += (is_drawing ? "L" : "M") + Number(scales.X(profile.at("distance_m")[i])) + " " +
                  Number(scales.Y(altitude));
    }
    is_drawing = !altitude.is_null();
  }
  return "<path class=\"" + std::string(css_class) + "\" d=\"" + commands + "\"/>";
}

std::string Text(double x, double y, const char* anchor, const std::string& text) {
  return "<text font-size=\"14\" x=\"" + Number(x) + "\" y=\"" + Number(y) + "\" text-anchor=\"" +
         anchor + "\">" + text + "</text>";
}

// Grey columns over ground that no image shows.
std::string UnseenColumns(const nlohmann::json& profile, const Scales& scales) {
  std::string columns;
  const nlohmann::json& distances = profile.at("distance_m");
  for (size_t i = 0; i < distances.size(); ++i) {
    if (!profile.at("terrain_m")[i].is_null()) continue;
    const double begin = scales.X(distances[i]);
    const double end = i + 1 < distances.size() ? scales.X(distances[i + 1]) : kRight;
    columns += "<rect class=\"unseen\" x=\"" + Number(begin) + "\" y=\"" + Number(kTop) +
               "\" width=\"" + Number(end - begin + 0.1) + "\" height=\"" + Number(kBottom - kTop) +
               "\"/>";
  }
  return columns;
}

std::string Axes(const Scales& scales) {
  return "<path class=\"axis\" d=\"M" + Number(kLeft) + " " + Number(kTop) + "V" + Number(kBottom) +
         "H" + Number(kRight) + "\"/>" +
         Text(kLeft - 6, kTop + 10, "end", FixedText(scales.highest_m, 0) + " m") +
         Text(kLeft - 6, kBottom, "end", FixedText(scales.lowest_m, 0) + " m") +
         Text(
             kLeft, kBottom + 20, "start", FixedText(scales.longest_m, 0) + " m before touchdown") +
         Text(kRight, kBottom + 20, "end", "touchdown");
}

}  // namespace

std::string ProfileFigure(const SitePlaces& site) {
  const nlohmann::json& profile = site.profile;
  if (!profile.is_object() || profile.at("distance_m").empty()) return "";
  const Scales scales = ScalesOf(profile);
  return "<h2>Profile of the final</h2>\n<figure><svg role=\"img\" aria-label=\"path and ground "
         "along the final\" viewBox=\"0 0 " +
         Number(kWidth) + " " + Number(kHeight) + "\">" + UnseenColumns(profile, scales) +
         Axes(scales) + Path(profile, "terrain_m", "terrain", scales) +
         Path(profile, "path_m", "final", scales) +
         "</svg><figcaption>Black: path. Brown: highest ground in the corridor. Grey: "
         "unseen.</figcaption></figure>\n";
}

}  // namespace freelsd
