#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

// Pieces to plan for each field that may be kept.
constexpr int kTriesPerField = 4;

using Piece = std::vector<cv::Point>;  // cells: x = column, y = row

// Cells of the region on which the touchdown disc fits: 255, else 0.
cv::Mat1b WideGround(const Region& region, const HazardLayers& hazards, double required_distance) {
  cv::Mat1b is_wide = cv::Mat1b::zeros(hazards.distance.size());
  for (const cv::Point& cell : hazards.grid.CellsIn(region.Footprint())) {
    if (hazards.distance(cell) >= required_distance) is_wide(cell) = 255;
  }
  return is_wide;
}

// Connected ground, cut along squares of `side` cells; largest piece first.
std::vector<Piece> PiecesOf(const cv::Mat1b& is_wide, int side) {
  cv::Mat1i labels;
  cv::connectedComponents(is_wide, labels, 8, CV_32S);
  std::map<std::tuple<int, int, int>, Piece> by_place;
  for (int row = 0; row < labels.rows; ++row) {
    for (int col = 0; col < labels.cols; ++col) {
      if (labels(row, col) == 0) continue;
      by_place[{labels(row, col), row / side, col / side}].emplace_back(col, row);
    }
  }
  std::vector<Piece> pieces;
  pieces.reserve(by_place.size());
  for (auto& [place, piece] : by_place) pieces.push_back(std::move(piece));
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.size() > b.size();
  });
  return pieces;
}

// The rectangle around a piece, widened by the discs of its touchdowns.
Region Around(const Piece& piece, const Region& region, const ElevationMap& map, double margin) {
  Polygon outline;
  double height = 0.0;
  for (const cv::Point& cell : piece) {
    const Eigen::Vector2d center = map.grid.CellCenter(cell.y, cell.x);
    for (const double east : {-margin, margin}) {
      for (const double north : {-margin, margin}) {
        outline.push_back(center + Eigen::Vector2d(east, north));
      }
    }
    height += map.elevation(cell) / static_cast<double>(piece.size());
  }
  Region field = region;
  field.corners_in_world.clear();
  for (const Eigen::Vector2d& corner : MinAreaRectangle(outline)) {
    field.corners_in_world.emplace_back(corner.x(), corner.y(), height);
  }
  field.area_m2 = Area(field.Footprint());
  return field;
}

bool IsNearAnother(const Site& site, const std::vector<Site>& others, double distance) {
  return std::any_of(others.begin(), others.end(), [&](const Site& other) {
    return other.plan.verdict != Verdict::kRejected &&
           (other.plan.touchdown_in_world - site.plan.touchdown_in_world).head<2>().norm() <
               distance;
  });
}

}  // namespace

std::vector<Region> FurtherFields(const Region& region,
                                  const ElevationMap& map,
                                  const HazardLayers& hazards,
                                  double required_hazard_distance,
                                  double max_extent_m) {
  if (hazards.distance.empty()) return {};
  const cv::Mat1b is_wide = WideGround(region, hazards, required_hazard_distance);
  const int side = std::max(1, static_cast<int>(max_extent_m / hazards.grid.cell_size_m));
  std::vector<Region> fields;
  for (const Piece& piece : PiecesOf(is_wide, side)) {
    fields.push_back(Around(piece, region, map, required_hazard_distance));
  }
  return fields;
}

std::vector<Site> WithFurtherSites(std::vector<Site> sites,
                                   const ElevationMap& map,
                                   const HazardLayers& hazards,
                                   const Aircraft& aircraft,
                                   const PipelineOptions& options,
                                   const std::function<Site(const Region& field)>& plan) {
  const int max_num_fields = options.backend.max_num_further_fields;
  if (max_num_fields == 0) return sites;
  const double required = RequiredHazardDistance(map, aircraft, options.approach);
  const double extent = options.backend.further_field_extent_m;
  const std::vector<Site> own_sites = sites;
  for (const Site& own : own_sites) {
    if (own.plan.verdict == Verdict::kRejected) continue;
    int number = 1, num_tried = 0;
    for (const Region& field : FurtherFields(own.region, map, hazards, required, extent)) {
      if (field.area_m2 < aircraft.min_area_m2) continue;
      if (number > max_num_fields || ++num_tried > kTriesPerField * max_num_fields) break;
      Site further = plan(field);
      if (further.plan.verdict == Verdict::kRejected) continue;
      if (IsNearAnother(further, sites, 0.5 * extent)) continue;
      further.field_number = ++number;
      sites.push_back(std::move(further));
    }
  }
  return sites;
}

}  // namespace freelsd
