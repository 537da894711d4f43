#include "engine/further_fields.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Pieces that are planned for each one that may be kept.
constexpr int kTriesPerField = 4;

using Piece = std::vector<cv::Point>;  // cells: x = column, y = row

// Cells of the region on which the touchdown disc fits: 255, else 0.
cv::Mat1b WideGround(const Region& region, const HazardLayers& hazards, double required_distance) {
  cv::Mat1b is_wide = cv::Mat1b::zeros(hazards.distance.size());
  const Polygon footprint = region.Footprint();
  for (int row = 0; row < is_wide.rows; ++row) {
    for (int col = 0; col < is_wide.cols; ++col) {
      if (!(hazards.distance(row, col) >= required_distance)) continue;
      if (Contains(footprint, hazards.grid.CellCenter(row, col))) is_wide(row, col) = 255;
    }
  }
  return is_wide;
}

// What hangs together, cut along the lines of squares of `side` cells; largest first.
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
  for (auto& [place, piece] : by_place) pieces.push_back(std::move(piece));
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.size() > b.size();
  });
  return pieces;
}

// The rectangle around a piece with the discs of its touchdowns.
Region Around(const Piece& piece,
              const Region& region,
              const Evaluation& evaluation,
              double margin) {
  Polygon outline;
  double height = 0.0;
  for (const cv::Point& cell : piece) {
    const Eigen::Vector2d center = evaluation.hazards.grid.CellCenter(cell.y, cell.x);
    for (const double east : {-margin, margin}) {
      for (const double north : {-margin, margin}) {
        outline.push_back(center + Eigen::Vector2d(east, north));
      }
    }
    height += evaluation.map.elevation(cell) / static_cast<double>(piece.size());
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
                                  const Evaluation& evaluation,
                                  double required_hazard_distance,
                                  double max_extent_m) {
  if (evaluation.hazards.distance.empty()) return {};
  const cv::Mat1b is_wide = WideGround(region, evaluation.hazards, required_hazard_distance);
  const double cell_size_m = evaluation.hazards.grid.cell_size_m;
  const int side = std::max(1, static_cast<int>(max_extent_m / cell_size_m));
  std::vector<Region> fields;
  for (const Piece& piece : PiecesOf(is_wide, side)) {
    fields.push_back(Around(piece, region, evaluation, required_hazard_distance));
  }
  return fields;
}

void AddFurtherSites(Evaluation& evaluation,
                     const Aircraft& aircraft,
                     const PipelineOptions& options,
                     const std::function<Site(const Region& field)>& plan) {
  const int max_num_fields = options.backend.max_num_further_fields;
  if (max_num_fields == 0) return;
  const double required = RequiredHazardDistance(evaluation.map, aircraft, options.approach);
  const double extent = options.backend.further_field_extent_m;
  const std::vector<Site> own_sites = evaluation.sites;
  for (const Site& own : own_sites) {
    if (own.plan.verdict == Verdict::kRejected) continue;
    int number = 1, num_tried = 0;
    for (const Region& field : FurtherFields(own.region, evaluation, required, extent)) {
      if (field.area_m2 < aircraft.min_area_m2) continue;
      if (number > max_num_fields || ++num_tried > kTriesPerField * max_num_fields) break;
      Site further = plan(field);
      if (further.plan.verdict == Verdict::kRejected) continue;
      if (IsNearAnother(further, evaluation.sites, 0.5 * extent)) continue;
      further.field_number = ++number;
      evaluation.sites.push_back(std::move(further));
    }
  }
}

}  // namespace freelsd
