#include <algorithm>

#include "api/export/color_ramp.h"
#include "api/export/report/drawing.h"
#include "api/export/report/figures.h"
#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

Eigen::AlignedBox2d BoxOf(const WorldBox& box) { return {box.min_in_world, box.max_in_world}; }

std::string Pictures(const GroundPicture& ground) {
  const Eigen::AlignedBox2d box = BoxOf(ground.box);
  return ImageIn(box, "image/jpeg", ground.photo_jpeg) +
         ImageIn(box, "image/png", ground.hazard_png);
}

// A disc with the site's rank: black if the site is landable, white if it is unverified.
std::string Mark(const Eigen::Vector2d& place, const StoredSite& site, double radius) {
  const std::string number = std::to_string(site.rank.value_or(0));
  // Three digits fit into the disc too.
  const double font = radius * (number.size() > 2 ? 1.0 : 1.3);
  return "<g class=\"mark " + VerdictOf(site) + "\"><circle cx=\"" + SvgNumber(place.x()) +
         "\" cy=\"" + SvgNumber(-place.y()) + "\" r=\"" + SvgNumber(radius) + "\"/><text x=\"" +
         SvgNumber(place.x()) + "\" y=\"" + SvgNumber(-place.y() + 0.36 * font) +
         "\" font-size=\"" + SvgNumber(font) + "\" text-anchor=\"middle\">" + number +
         "</text></g>";
}

struct DrawnSite {
  const StoredSite* site = nullptr;
  SiteLines lines;
};

// Accepted sites on the map, the best last: it is drawn above the others.
std::vector<DrawnSite> SitesIn(const Eigen::AlignedBox2d& box, const FlightReport& report) {
  std::vector<DrawnSite> drawn;
  const auto add = [&](const StoredSite& site) {
    SiteLines lines = LinesOf(site, report.local_frame);
    if (box.contains(lines.touchdown)) drawn.push_back({&site, std::move(lines)});
  };
  for (const ReportedSite& site : report.sites) add(site.site);
  for (const StoredSite& site : report.further_sites) add(site);
  std::reverse(drawn.begin(), drawn.end());
  return drawn;
}

// A cross at the least bad place of a rejected region.
std::string Cross(const Eigen::Vector2d& place, double radius) {
  const std::string side = SvgNumber(2.0 * radius);
  const std::string line = "\" d=\"M" + SvgNumber(place.x() - radius) + " " +
                           SvgNumber(-place.y() - radius) + "l" + side + " " + side + "m-" + side +
                           " 0l" + side + " -" + side + "\"/>";
  return "<path class=\"casing" + line + "<path class=\"cross" + line;
}

std::string CrossesIn(const Eigen::AlignedBox2d& box, const FlightReport& report, double radius) {
  std::string crosses;
  for (const StoredSite& site : report.rejected_sites) {
    const Eigen::Vector2d place = LinesOf(site, report.local_frame).touchdown;
    if (box.contains(place)) crosses += Cross(place, radius);
  }
  return crosses;
}

std::string Swatch(const std::string& content, const std::string& text) {
  return "<li><svg aria-hidden=\"true\" viewBox=\"0 0 28 18\">" + content + "</svg>" + text +
         "</li>\n";
}

std::string ColorSwatch(const Color& color, const std::string& lines, const std::string& text) {
  return Swatch("<rect width=\"28\" height=\"18\" fill=\"rgb(" + std::to_string(color[0]) + "," +
                    std::to_string(color[1]) + "," + std::to_string(color[2]) + ")\"/>" + lines,
                text);
}

std::string LineSwatch(const std::string& css_class, const std::string& text) {
  return Swatch("<path class=\"" + css_class + "\" d=\"M1 9H27\"/>", text);
}

std::string MarkSwatch(const std::string& verdict) {
  return Swatch("<g class=\"mark " + verdict +
                    "\"><circle cx=\"14\" cy=\"9\" r=\"8\"/><text x=\"14\" y=\"13\" "
                    "font-size=\"11\" text-anchor=\"middle\">1</text></g>",
                "site, " + verdict + ", with its rank");
}

std::string Legend(const ReportedMap& map) {
  return "<ul class=\"legend\">\n" + ColorSwatch(kFreeColor, "", "free of hazard") +
         ColorSwatch(
             kHazardColor, "<path class=\"hatch hazard\" d=\"M0 0L18 18M14 0L28 14\"/>", "hazard") +
         Swatch(
             "<rect width=\"28\" height=\"18\" fill=\"#e6e6e6\"/><path class=\"hatch\" d=\"M0 "
             "8L8 0M0 18L18 0M10 18L28 0M20 18L28 10\"/>",
             "unseen: no photograph shows it well enough") +
         Swatch("<rect width=\"28\" height=\"18\" class=\"beyond\"/>", "beyond the map") +
         MarkSwatch("landable") + MarkSwatch("unverified") +
         Swatch("<path class=\"cross\" d=\"M9 4l10 10m-10 0l10 -10\"/>", "rejected place") +
         LineSwatch("final", "final") + LineSwatch("circle", "circle before the final") +
         LineSwatch("strip", "strip of the ground roll") + "</ul>\n" +
         (map.ground.photo_jpeg.empty() ? "<p>The map has no photograph of the ground.</p>\n" : "");
}

// Whole circles, but at least a margin around the map.
Eigen::AlignedBox2d DrawnBox(const Eigen::AlignedBox2d& map_box,
                             const std::vector<DrawnSite>& sites) {
  Eigen::AlignedBox2d box = map_box;
  for (const DrawnSite& drawn : sites) box.extend(drawn.lines.WholeBox());
  return Grown(box, 0.01 * box.sizes().maxCoeff());
}

}  // namespace

WorldBox LandingBoxOf(const StoredSite& site, const LocalFrame& local_frame) {
  constexpr double kAroundLandingM = 25.0;
  const Eigen::AlignedBox2d landing = LinesOf(site, local_frame).LandingBox();
  const Eigen::Vector2d half_side =
      Eigen::Vector2d::Constant(0.5 * landing.sizes().maxCoeff() + kAroundLandingM);
  return {landing.center() - half_side, landing.center() + half_side};
}

std::string FlightMapFigure(const FlightReport& report,
                            const ReportedMap& map,
                            const std::string& title) {
  const Eigen::AlignedBox2d map_box = BoxOf(map.ground.box);
  const std::vector<DrawnSite> drawn = SitesIn(map_box, report);
  const Eigen::AlignedBox2d box = DrawnBox(map_box, drawn);
  const double mark_radius = 0.016 * box.sizes().maxCoeff();
  std::string paths, marks = CrossesIn(map_box, report, 0.5 * mark_radius);
  for (const DrawnSite& each : drawn) {
    paths += PathOf(each.lines);
    marks += Mark(each.lines.touchdown, *each.site, mark_radius);
  }
  return "<figure class=\"flight-map\"><div>" +
         Svg(title, box, Pictures(map.ground) + paths + marks + ScaleAndNorth(box)) +
         "</div><figcaption><b>" + EscapeXml(title) + "</b>\n" + Legend(map) +
         "</figcaption></figure>\n";
}

std::string CutOutFigure(const ReportedSite& site, const LocalFrame& local_frame) {
  if (!site.ground) return "";
  const Eigen::AlignedBox2d box = BoxOf(site.ground->box);
  const SiteLines lines = LinesOf(site.site, local_frame);
  const std::string what = site.ground->photo_jpeg.empty() ? "Hazard" : "Photograph";
  return "<figure class=\"cut-out\">" +
         Svg("the landing from above",
             box,
             Pictures(*site.ground) + PathOf(lines) +
                 TouchdownDot(lines.touchdown, box, kSmallFigureShare) +
                 ScaleAndNorth(box, kSmallFigureShare)) +
         "<figcaption>" + what +
         " from above. Dot: touchdown. Thick line: final. Thin line: strip of the ground roll. "
         "Dashed: circle. White: unseen.</figcaption></figure>\n";
}

std::string CoverageFigure(const ReportedMap& map) {
  if (map.coverage_png.empty()) return "";
  const Eigen::AlignedBox2d box = BoxOf(map.ground.box);
  return "<figure class=\"coverage\">" +
         Svg("number of photographs that see each place",
             box,
             ImageIn(box, "image/png", map.coverage_png) + ScaleAndNorth(box, kSmallFigureShare)) +
         "<figcaption>Number of photographs that see each place. Grey: unseen." +
         "<img alt=\"legend of the coverage\" src=\"" +
         DataUri("image/png", map.coverage_legend_png) + "\"/></figcaption></figure>\n";
}

}  // namespace freelsd
