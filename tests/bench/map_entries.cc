// From points to touchdown and approach, and what one would write with OpenCV or a plain loop for
// each.
#include <cmath>
#include <limits>
#include <random>

#include <opencv2/imgproc.hpp>

#include "engine/pipeline.h"
#include "tests/bench/contest.h"
#include "tests/engine/hazard/assess.h"

namespace freelsd {
namespace {

// The paper's map: 4.2 million points on 300 x 300 cells of 1 m.
constexpr int kNumCells = 300;
constexpr int kNumPairs = 40;
constexpr int kNumPointsOfPair = 105000;

double Rolling(double x, double y) { return 2.0 * std::sin(x / 40.0) + 1.5 * std::cos(y / 55.0); }

Grid PaperGrid() {
  const double half = 0.5 * kNumCells;
  return GridAround({-half, -half}, {half, half}, 1.0);
}

// Of a pair that sees one part of the map, as stereo gives them: 25 per square metre, row by row.
Points PointsOfPair(int pair) {
  constexpr int kNumPairsPerRow = 8;
  constexpr double kSpacing = 0.2, kWidth = 65.0;
  const double reach = kNumCells - kWidth;
  constexpr int kNumRows = kNumPairs / kNumPairsPerRow;
  const int row = pair / kNumPairsPerRow;
  const double west = reach * (pair % kNumPairsPerRow) / (kNumPairsPerRow - 1.0);
  const double south = reach * row / (kNumRows - 1.0);
  const int num_per_row = static_cast<int>(kWidth / kSpacing);
  std::mt19937 random(static_cast<unsigned>(pair) + 1);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  Points points(kNumPointsOfPair);
  for (int i = 0; i < kNumPointsOfPair; ++i) {
    const int point_row = i / num_per_row;
    const double x = west - 0.5 * kNumCells + kSpacing * (i % num_per_row + uniform());
    const double y = south - 0.5 * kNumCells + kSpacing * (point_row + uniform());
    const double z = Rolling(x, y) + 0.2 * (uniform() + uniform() - 1.0);
    points[static_cast<size_t>(i)] = {Eigen::Vector3d(x, y, z).cast<float>(), 0.2f};
  }
  return points;
}

std::vector<Points> PaperPoints() {
  std::vector<Points> pairs;
  pairs.reserve(kNumPairs);
  for (int pair = 0; pair < kNumPairs; ++pair) pairs.push_back(PointsOfPair(pair));
  return pairs;
}

// Inverse-distance weights within 1 m, one pass, in double: no counts, deviations, upper heights or
// outliers.
cv::Mat1f PlainMap(const std::vector<Points>& pairs) {
  cv::Mat1d sum(kNumCells, kNumCells, 0.0), weight(kNumCells, kNumCells, 0.0);
  const double half = 0.5 * kNumCells;
  for (const Points& points : pairs) {
    for (const DensePoint& point : points) {
      const double u = point.point_in_world.x() + half - 0.5;
      const double v = half - point.point_in_world.y() - 0.5;
      const int col = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
      for (int r = std::max(row, 0); r <= std::min(row + 1, kNumCells - 1); ++r) {
        for (int c = std::max(col, 0); c <= std::min(col + 1, kNumCells - 1); ++c) {
          const double squared = (u - c) * (u - c) + (v - r) * (v - r);
          if (squared > 1.0) continue;
          const double w = 1.0 / std::max(squared, 1e-12);
          sum(r, c) += w * point.point_in_world.z();
          weight(r, c) += w;
        }
      }
    }
  }
  return cv::Mat1d(sum / weight);
}

ElevationMap MapOf(const std::vector<Points>& pairs, HeightFusion fusion) {
  TerrainOptions options;
  options.height_fusion = fusion;
  ElevationMapBuilder builder(PaperGrid(), options);
  for (const Points& points : pairs) builder.Add(points);
  return builder.Build();
}

Contest Elevation(const std::string& name, HeightFusion fusion) {
  const auto pairs = std::make_shared<std::vector<Points>>(PaperPoints());
  return {name,
          "4.2e6 points, 300x300 cells",
          [=] { Consume(MapOf(*pairs, fusion).elevation(0, 0)); },
          "plain weighted mean, one pass in double, nothing else",
          [pairs] { Consume(PlainMap(*pairs)(0, 0)); }};
}

ElevationMap PaperMap() { return MapOf(PaperPoints(), HeightFusion::kRobust); }

// One camera straight above that calls everything grass but a block in one corner.
std::vector<KindView> GrassFromAbove(int num_views) {
  KindView view;
  view.world_from_camera = {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {0.0, 0.0, 300.0}};
  view.camera.width_px = view.camera.height_px = kNumCells + 60;
  view.camera.fx_px = view.camera.fy_px = 300.0;
  view.camera.cx_px = view.camera.cy_px = 0.5 * (kNumCells + 60);
  view.picture.grass = cv::Mat1b(kNumCells + 60, kNumCells + 60, uint8_t{240});
  view.picture.grass(cv::Rect(0, 0, 100, 100)) = 20;
  return std::vector<KindView>(static_cast<size_t>(num_views), view);
}

// Slope by Sobel, ruggedness by eight differences, distance by OpenCV.
double PlainLayers(const cv::Mat1f& elevation) {
  cv::Mat1f east, north, steepness;
  cv::Sobel(elevation, east, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(elevation, north, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(east, north, steepness);
  cv::Mat1f squares(elevation.size(), 0.0f);
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const cv::Mat1f shift = (cv::Mat1f(2, 3) << 1, 0, i, 0, 1, j);
      cv::Mat1f moved;
      cv::warpAffine(elevation, moved, shift, elevation.size());
      const cv::Mat1f difference = moved - elevation;
      squares += difference.mul(difference);
    }
  }
  cv::Mat1f roughness, distance;
  cv::sqrt(squares, roughness);
  const cv::Mat1b free = (steepness < std::tan(RadFromDeg(8.0))) & (roughness < 0.5f);
  cv::distanceTransform(free, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance(kNumCells / 2, kNumCells / 2);
}

PlanRequest WholeMap(const Eigen::Vector2d& wind) {
  PlanRequest request;
  const double half = 0.5 * kNumCells - 20.0;
  request.footprint = {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
  request.area_m2 = 4.0 * half * half;
  request.grade = 1.0;
  request.num_observations = 10;
  request.wind_in_world = wind;
  return request;
}

// Everything from points to a touchdown with its approach.
Contest DecisionLayers(const std::string& name, HeightFusion fusion) {
  const auto pairs = std::make_shared<std::vector<Points>>(PaperPoints());
  // Two: one view alone is not enough for grass.
  const auto views = std::make_shared<std::vector<KindView>>(GrassFromAbove(2));
  return {name,
          "4.2e6 points, 300x300 cells",
          [=] {
            const ElevationMap map = MapOf(*pairs, fusion);
            const HazardLayers layers = AssessHazards(map, *views, HazardLimits{}, HazardOptions{});
            const PlanRequest request = WholeMap(Eigen::Vector2d(0.0, 5.5));
            Consume(PlanApproach(map, layers, request, Aircraft{}, ApproachOptions{}).score);
          },
          "plain weighted mean in double, Sobel, eight differences, distanceTransform",
          [=] { Consume(PlainLayers(PlainMap(*pairs))); }};
}

Contest Layers() {
  const auto map = std::make_shared<ElevationMap>(PaperMap());
  const auto views = std::make_shared<std::vector<KindView>>(GrassFromAbove(10));
  return {
      "layers",
      "300x300 cells, 10 views",
      [=] { Consume(AssessHazards(*map, *views, HazardLimits{}, HazardOptions{}).distance(0, 0)); },
      "Sobel, eight differences, distanceTransform; no grass, nothing unseen",
      [=] { Consume(PlainLayers(map->elevation)); }};
}

Contest Relimit() {
  const auto map = std::make_shared<ElevationMap>(PaperMap());
  const auto layers = std::make_shared<HazardLayers>(
      AssessHazards(*map, GrassFromAbove(10), HazardLimits{}, HazardOptions{}));
  return {
      "hazard_distance",
      "300x300 cells",
      [=] { Consume(WithLimits(*map, *layers, HazardLimits{}, HazardOptions{}).distance(0, 0)); },
      "distanceTransform, precise",
      [=] {
        cv::Mat1f distance;
        cv::distanceTransform(
            layers->hazard == kFree, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
        Consume(distance(0, 0));
      }};
}

// Heights of a final and of the circle at its start, cell by cell, for one touchdown and wind.
double PlainPathCheck(const cv::Mat1f& upper,
                      const Aircraft& aircraft,
                      const Eigen::Vector2d& wind) {
  const double final_m = ApproachDistance(aircraft, wind.norm());
  const double radius = LoiterRadius(aircraft, wind.norm());
  const Eigen::Vector2d middle = Eigen::Vector2d::Constant(0.5 * kNumCells);
  const Eigen::Vector2d downwind = wind.normalized();
  const Eigen::Vector2d across(-downwind.y(), downwind.x());
  double least = std::numeric_limits<double>::infinity();
  const auto look = [&](const Eigen::Vector2d& place, double height) {
    const int col = static_cast<int>(place.x()), row = static_cast<int>(place.y());
    if (col < 0 || row < 0 || col >= upper.cols || row >= upper.rows) return;
    least = std::min(least, height - upper(row, col));
  };
  for (double s = 0.0; s < final_m; s += 1.0) {
    look(middle + s * downwind, aircraft.approach_height_m * s / final_m);
  }
  const Eigen::Vector2d center = middle + final_m * downwind + radius * across;
  for (double angle = 0.0; angle < 2.0 * kPi; angle += 1.0 / radius) {
    look(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
         aircraft.approach_height_m);
  }
  return least;
}

struct Site {
  ElevationMap map;
  HazardLayers layers;
};

std::shared_ptr<const Site> PaperSite() {
  auto site = std::make_shared<Site>();
  site->map = PaperMap();
  site->layers = AssessHazards(site->map, GrassFromAbove(10), HazardLimits{}, HazardOptions{});
  return site;
}

constexpr char kPlainPath[] = "one line of cells along final and circle, one touchdown";

Contest OneWind() {
  const Eigen::Vector2d wind(0.0, 5.5);
  return {
      "approach",
      "300x300 cells, 1 wind",
      [site = PaperSite(), wind] {
        const PlanRequest request = WholeMap(wind);
        Consume(
            PlanApproach(site->map, site->layers, request, Aircraft{}, ApproachOptions{}).score);
      },
      kPlainPath,
      [site = PaperSite(), wind] { Consume(PlainPathCheck(site->map.upper, {}, wind)); }};
}

Contest AllWinds() {
  const WindRoseOptions winds{.num_directions = 72, .speeds_mps = {1.0, 2.5, 4.0, 5.5, 7.0}};
  return {"wind_rose",
          "300x300 cells, 360 winds",
          [site = PaperSite(), winds] {
            const ApproachPlanner planner(
                site->map, site->layers, WholeMap({0.0, 0.0}), Aircraft{}, ApproachOptions{});
            Consume(PlanWindRose(planner, winds).plans.front().hazard_distance);
          },
          kPlainPath,
          [site = PaperSite(), winds] {
            for (const double speed : winds.speeds_mps) {
              for (int i = 0; i < winds.num_directions; ++i) {
                const Eigen::Vector2d towards = DirectionOf(2.0 * kPi * i / winds.num_directions);
                Consume(PlainPathCheck(site->map.upper, {}, speed * towards));
              }
            }
          }};
}

}  // namespace

std::vector<Entry> MapEntries() {
  return {
      {"elevation_paper", [] { return Elevation("elevation_paper", HeightFusion::kPaperMean); }},
      {"elevation", [] { return Elevation("elevation", HeightFusion::kRobust); }},
      {"layers", [] { return Layers(); }},
      {"hazard_distance", [] { return Relimit(); }},
      {"decision_paper", [] { return DecisionLayers("decision_paper", HeightFusion::kPaperMean); }},
      {"decision", [] { return DecisionLayers("decision", HeightFusion::kRobust); }},
      {"approach", [] { return OneWind(); }},
      {"wind_rose", [] { return AllWinds(); }},
  };
}

}  // namespace freelsd
