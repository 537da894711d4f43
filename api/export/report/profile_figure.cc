#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/report/figures.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

constexpr double kWidth = 800.0, kHeight = 220.0;
constexpr double kLeft = 60.0, kRight = 780.0, kTop = 20.0, kBottom = 185.0;

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

using Profile = std::vector<ProfilePoint>;

Scales ScalesOf(const Profile& profile) {
  Scales scales;
  for (const ProfilePoint& point : profile) {
    scales.longest_m = std::max(scales.longest_m, point.distance_m);
    for (const std::optional<double>& altitude_m : {point.path_m, point.terrain_m}) {
      if (!altitude_m) continue;
      scales.lowest_m = std::min(scales.lowest_m, *altitude_m);
      scales.highest_m = std::max(scales.highest_m, *altitude_m);
    }
  }
  // Level ground is drawn as a line at the bottom; the least range avoids a division by zero.
  scales.lowest_m -= 1.0;
  scales.highest_m += 1.0;
  return scales;
}

std::string Number(double number) { return FixedText(number, 1); }

// The line is broken where an altitude is unknown.
std::string Path(const Profile& profile,
                 std::optional<double> ProfilePoint::*altitude_m,
                 const char* css_class,
                 const Scales& scales) {
  std::string commands;
  bool is_drawing = false;
  for (const ProfilePoint& point : profile) {
    const std::optional<double> y_m = point.*altitude_m;
    if (y_m) {
      commands += (is_drawing ? "L" : "M") + Number(scales.X(point.distance_m)) + " " +
                  Number(scales.Y(*y_m));
    }
    is_drawing = y_m.has_value();
  }
  return "<path class=\"" + std::string(css_class) + "\" d=\"" + commands + "\"/>";
}

std::string Text(double x, double y, const char* anchor, const std::string& text) {
  return "<text font-size=\"14\" x=\"" + Number(x) + "\" y=\"" + Number(y) + "\" text-anchor=\"" +
         anchor + "\">" + text + "</text>";
}

// Grey columns over ground that no image shows.
std::string UnseenColumns(const Profile& profile, const Scales& scales) {
  std::string columns;
  for (size_t i = 0; i < profile.size(); ++i) {
    if (profile[i].terrain_m) continue;
    const double begin = scales.X(profile[i].distance_m);
    const double end = i + 1 < profile.size() ? scales.X(profile[i + 1].distance_m) : kRight;
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

std::string ProfileFigure(const StoredSite& site) {
  const Profile& profile = site.profile;
  if (profile.empty()) return "";
  const Scales scales = ScalesOf(profile);
  return "<figure class=\"profile\"><svg role=\"img\" aria-label=\"path and ground "
         "along the final\" viewBox=\"0 0 " +
         Number(kWidth) + " " + Number(kHeight) + "\">" + UnseenColumns(profile, scales) +
         Axes(scales) + Path(profile, &ProfilePoint::terrain_m, "terrain", scales) +
         Path(profile, &ProfilePoint::path_m, "final", scales) +
         "</svg><figcaption>Black: path. Brown: highest ground in the corridor. Grey: "
         "unseen.</figcaption></figure>\n";
}

}  // namespace freelsd
