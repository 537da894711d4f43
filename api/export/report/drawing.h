// Private to report/. Parts of SVG drawings of ground: x is world east, y is world south, metres.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "api/stored/stored.h"

namespace freelsd {

// Lines of a site in world, east and north in metres.
struct SiteLines {
  Eigen::Vector2d touchdown = Eigen::Vector2d::Zero();
  // The first two are empty if the site has no approach.
  Polygon final_line;
  Polygon circle;
  // Closed; empty if the aircraft needs no ground roll.
  Polygon ground_roll;

  // Around touchdown, final and ground roll.
  Eigen::AlignedBox2d LandingBox() const;
  // The same with the circle.
  Eigen::AlignedBox2d WholeBox() const;
};
SiteLines LinesOf(const StoredSite& site, const LocalFrame& local_frame);

Eigen::AlignedBox2d Grown(const Eigen::AlignedBox2d& box, double margin_m);

std::string DataUri(const std::string& media_type, const std::string& bytes);
// To the centimetre.
std::string SvgNumber(double number);
// `label` describes the drawing for people who do not see it. It is escaped.
std::string Svg(const std::string& label,
                const Eigen::AlignedBox2d& box,
                const std::string& content);
// A picture that fills the box; nothing without a picture.
std::string ImageIn(const Eigen::AlignedBox2d& box,
                    const std::string& media_type,
                    const std::string& bytes);
// Strip, circle and final.
std::string PathOf(const SiteLines& lines);
// The size of letters and marks, as a share of the drawing's longer side. It is larger for a small
// figure.
constexpr double kUsualShare = 0.03;
constexpr double kSmallFigureShare = 0.05;
std::string TouchdownDot(const Eigen::Vector2d& place,
                         const Eigen::AlignedBox2d& box,
                         double share = kUsualShare);
std::string ScaleAndNorth(const Eigen::AlignedBox2d& box, double share = kUsualShare);

}  // namespace freelsd
