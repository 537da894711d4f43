#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

// Pieces to plan for each site that may be kept.
constexpr int kTriesPerSite = 4;

// Cells of one square of one piece of connected ground: x = column, y = row.
struct Piece {
  MapSquare square;
  std::vector<cv::Point> cells;
};

MapSquare SquareOf(const Eigen::Vector2d& place_in_world, double side_m) {
  return {static_cast<int>(std::floor(place_in_world.x() / side_m)),
          static_cast<int>(std::floor(place_in_world.y() / side_m))};
}

// Ground on which the touchdown disc fits, cut along squares of the world; largest piece first.
std::vector<Piece> PiecesOf(const HazardLayers& layers, double required_distance, double side_m) {
  if (layers.distance.empty() || std::isnan(required_distance)) return {};
  const cv::Mat1b is_wide(layers.distance >= required_distance);
  cv::Mat1i labels;
  cv::connectedComponents(is_wide, labels, 8, CV_32S);
  std::map<std::tuple<int, int, int>, Piece> by_place;
  for (int row = 0; row < labels.rows; ++row) {
    for (int col = 0; col < labels.cols; ++col) {
      if (labels(row, col) == 0) continue;
      const MapSquare square = SquareOf(layers.grid.CellCenter(row, col), side_m);
      Piece& piece = by_place[{labels(row, col), square.east, square.north}];
      piece.square = square;
      piece.cells.emplace_back(col, row);
    }
  }
  std::vector<Piece> pieces;
  pieces.reserve(by_place.size());
  for (auto& [place, piece] : by_place) pieces.push_back(std::move(piece));
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.cells.size() > b.cells.size();
  });
  return pieces;
}

// What the map shows of the piece, in the form of a region: its rectangle, widened by the discs of
// its touchdowns; half of its cells were seen at least this often.
Region FieldAround(const Piece& piece, const MapOfSites& on, double margin) {
  const ElevationMap& map = on.map;
  Polygon outline;
  std::vector<int> num_views;
  num_views.reserve(piece.cells.size());
  double height = 0.0, grass = 0.0;
  for (const cv::Point& cell : piece.cells) {
    const Eigen::Vector2d center = map.grid.CellCenter(cell.y, cell.x);
    for (const double east : {-margin, margin}) {
      for (const double north : {-margin, margin}) {
        outline.push_back(center + Eigen::Vector2d(east, north));
      }
    }
    height += map.elevation(cell);
    grass += on.layers.grass(cell);
    num_views.push_back(on.num_views(cell));
  }
  const auto num_cells = static_cast<double>(piece.cells.size());
  const auto middle = num_views.begin() + static_cast<std::ptrdiff_t>(num_views.size() / 2);
  std::nth_element(num_views.begin(), middle, num_views.end());
  Region field;
  for (const Eigen::Vector2d& corner : MinAreaRectangle(outline)) {
    field.corners_in_world.emplace_back(corner.x(), corner.y(), height / num_cells);
  }
  field.area_m2 = Area(field.Footprint());
  field.grade = grass / num_cells;
  field.num_observations = *middle;
  field.num_grass_observations = static_cast<int>(std::lround(field.grade * *middle));
  return field;
}

double DistanceBetween(const Site& a, const Site& b) {
  return (a.plan.touchdown_in_world - b.plan.touchdown_in_world).head<2>().norm();
}

bool IsOneOf(const MapSquare& square, const std::vector<Site>& sites) {
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    return site.square && site.square->east == square.east && site.square->north == square.north;
  });
}

bool IsNearAny(const Site& site, const std::vector<Site>& others, double distance) {
  return std::any_of(others.begin(), others.end(), [&](const Site& other) {
    return other.plan.verdict != Verdict::kRejected && DistanceBetween(site, other) < distance;
  });
}

// Landable before unverified, then by risk. Sites of equal risk keep their order.
void SortBest(std::vector<Site>& sites) {
  std::stable_sort(sites.begin(), sites.end(), [](const Site& a, const Site& b) {
    return std::tuple(a.plan.verdict, -a.plan.score) < std::tuple(b.plan.verdict, -b.plan.score);
  });
}

// The tracked region that a site lies in; the first one of several.
const Region* RegionAt(const Eigen::Vector3d& place_in_world, std::span<const Site> of_regions) {
  const Eigen::Vector2d place = place_in_world.head<2>();
  const auto found = std::find_if(of_regions.begin(), of_regions.end(), [&](const Site& site) {
    return Contains(site.region.Footprint(), place);
  });
  return found == of_regions.end() ? nullptr : &found->region;
}

// The paper's record of the region, if the site lies in one that was seen as grass.
void TellRegion(Site& site, std::span<const Site> of_regions) {
  const Region* const region = RegionAt(site.plan.touchdown_in_world, of_regions);
  if (region == nullptr || !(region->grade > 0.0)) return;
  const Region field = std::exchange(site.region, *region);
  site.region.corners_in_world = field.corners_in_world;
  site.region.area_m2 = field.area_m2;
}

}  // namespace

std::vector<Site> WithMapSites(std::vector<Site> of_regions,
                               const MapOfSites& on,
                               const Aircraft& aircraft,
                               const PipelineOptions& options,
                               const PlanFields& plan) {
  const auto max_num_sites = static_cast<size_t>(options.backend.max_num_map_sites);
  const double side_m = options.backend.map_site_extent_m;
  const double required = RequiredHazardDistance(on.map, aircraft, options.approach);
  const double strip_m = 2.0 * aircraft.touchdown_uncertainty_m + aircraft.ground_roll_m;
  std::vector<Region> fields;
  std::vector<MapSquare> squares;
  for (const Piece& piece : PiecesOf(on.layers, required, side_m)) {
    const Region field = FieldAround(piece, on, required);
    if (field.area_m2 < aircraft.min_area_m2) continue;
    if (fields.size() >= kTriesPerSite * max_num_sites) break;
    fields.push_back(field);
    squares.push_back(piece.square);
  }
  std::vector<Site> found = plan(fields);
  for (size_t i = 0; i < found.size(); ++i) found[i].square = squares[i];
  std::erase_if(found, [](const Site& site) { return site.plan.verdict == Verdict::kRejected; });
  SortBest(found);
  const size_t num_of_regions = of_regions.size();
  std::vector<Site> sites = std::move(of_regions);
  for (Site& site : found) {
    if (sites.size() >= num_of_regions + max_num_sites) break;
    if (IsNearAny(site, sites, strip_m) || IsOneOf(*site.square, sites)) continue;
    TellRegion(site, std::span(sites).first(num_of_regions));
    sites.push_back(std::move(site));
  }
  return sites;
}

}  // namespace freelsd
