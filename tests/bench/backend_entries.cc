// Stages of the backend, and what one would write with OpenCV or a plain loop for each.
#include <cmath>
#include <limits>
#include <random>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/bench/bench_scene.h"
#include "tests/bench/contest.h"

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

std::vector<Points> PaperPoints() {
  std::mt19937 random(1);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<Points> pairs(kNumPairs);
  for (Points& points : pairs) {
    points.resize(kNumPointsOfPair);
    for (DensePoint& point : points) {
      const double x = kNumCells * (uniform() - 0.5), y = kNumCells * (uniform() - 0.5);
      const double z = Rolling(x, y) + 0.2 * (uniform() + uniform() - 1.0);
      point = {Eigen::Vector3d(x, y, z).cast<float>(), 0.2f};
    }
  }
  return pairs;
}

// Inverse-distance weights within 1 m, one pass, in double: no counts, deviations, upper heights or
// outliers.
double PlainElevation(const std::vector<Points>& pairs) {
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
  const cv::Mat1d mean = sum / weight;
  return mean(kNumCells / 2, kNumCells / 2);
}

Contest Elevation() {
  const auto pairs = std::make_shared<std::vector<Points>>(PaperPoints());
  return {"elevation",
          "4.2e6 points, 300x300 cells",
          [pairs] {
            ElevationMapBuilder builder(PaperGrid(), TerrainOptions{});
            for (const Points& points : *pairs) builder.Add(points);
            Consume(builder.Build().elevation(0, 0));
          },
          "plain weighted mean, one pass in double, nothing else",
          [pairs] { Consume(PlainElevation(*pairs)); }};
}

ElevationMap PaperMap() {
  ElevationMapBuilder builder(PaperGrid(), TerrainOptions{});
  for (const Points& points : PaperPoints()) builder.Add(points);
  return builder.Build();
}

// One camera straight above that calls everything grass but a block in one corner.
std::vector<GrassView> GrassFromAbove(int num_views) {
  GrassView view;
  view.world_from_camera = {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {0.0, 0.0, 300.0}};
  view.camera.width_px = view.camera.height_px = kNumCells + 60;
  view.camera.fx_px = view.camera.fy_px = 300.0;
  view.camera.cx_px = view.camera.cy_px = 0.5 * (kNumCells + 60);
  view.mask = cv::Mat1b(kNumCells + 60, kNumCells + 60, uint8_t{240});
  view.mask(cv::Rect(0, 0, 100, 100)) = 20;
  return std::vector<GrassView>(static_cast<size_t>(num_views), view);
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

Contest Layers() {
  const auto map = std::make_shared<ElevationMap>(PaperMap());
  const auto views = std::make_shared<std::vector<GrassView>>(GrassFromAbove(10));
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

Contest WindRose(const std::string& name, int num_directions, const std::vector<double>& speeds) {
  const auto map = std::make_shared<ElevationMap>(PaperMap());
  const auto layers = std::make_shared<HazardLayers>(
      AssessHazards(*map, GrassFromAbove(10), HazardLimits{}, HazardOptions{}));
  std::vector<Eigen::Vector2d> winds;
  for (int i = 0; i < num_directions; ++i) {
    const double angle = 2.0 * kPi * i / num_directions;
    for (const double speed : speeds) {
      winds.emplace_back(speed * std::sin(angle), speed * std::cos(angle));
    }
  }
  return {
      name,
      "300x300 cells, " + std::to_string(winds.size()) + " winds",
      [=] {
        for (const Eigen::Vector2d& wind : winds) {
          Consume(PlanApproach(*map, *layers, WholeMap(wind), Aircraft{}, ApproachOptions{}).score);
        }
      },
      "one line of cells along final and circle, one touchdown",
      [=] {
        for (const Eigen::Vector2d& wind : winds) {
          Consume(PlainPathCheck(map->upper, Aircraft{}, wind));
        }
      }};
}

// Rectified by OpenCV and matched by its slower, better mode, as aerial_mapper sets it.
double PlainStereo(const cv::Mat& left,
                   const cv::Mat& right,
                   const cv::Mat& map_x,
                   const cv::Mat& map_y) {
  constexpr int kNumDisparities = 80, kBlockPx = 9;
  cv::Mat1b grey[2];
  const cv::Mat* images[2] = {&left, &right};
  for (int i = 0; i < 2; ++i) {
    cv::Mat rectified;
    cv::remap(*images[i], rectified, map_x, map_y, cv::INTER_LINEAR);
    cv::cvtColor(rectified, grey[i], cv::COLOR_BGR2GRAY);
  }
  const auto matcher = cv::StereoSGBM::create(
      1, kNumDisparities, kBlockPx, 120, 250, 0, 35, 10, 100, 20, cv::StereoSGBM::MODE_SGBM);
  cv::Mat disparity, points;
  matcher->compute(grey[0], grey[1], disparity);
  cv::reprojectImageTo3D(disparity, points, cv::Mat::eye(4, 4, CV_64F));
  return points.at<cv::Vec3f>(0, 0)[2];
}

Contest Stereo(const BenchScene& scene) {
  const cv::Mat left = scene.frames[scene.pair.left].image;
  const cv::Mat right = scene.frames[scene.pair.right].image;
  cv::Mat1f map_x(left.size()), map_y(left.size());
  for (int row = 0; row < left.rows; ++row) {
    for (int col = 0; col < left.cols; ++col) {
      map_x(row, col) = static_cast<float>(col) + 0.25f;
      map_y(row, col) = static_cast<float>(row) + 0.25f;
    }
  }
  return {
      "stereo",
      SizeOf(left),
      [=, &scene] {
        Consume(static_cast<double>(
            ReconstructPoints(scene.block, scene.pair, left, right, scene.options.stereo).size()));
      },
      "remap twice, StereoSGBM of 5 directions and 80 disparities, reprojectImageTo3D",
      [=] { Consume(PlainStereo(left, right, map_x, map_y)); }};
}

// Per view. OpenCV has no adjustment of cameras that move.
Contest Adjustment(const BenchScene& scene) {
  const size_t num_views = scene.snapshot.views.size();
  return {"bundle_adjustment",
          std::to_string(num_views) + " views, " + std::to_string(scene.block.landmarks.size()) +
              " landmarks",
          [&scene] {
            Consume(AdjustPoses(scene.snapshot.views, scene.rig.camera, scene.options.adjustment)
                        .rms_after_px);
          },
          "",
          {},
          static_cast<double>(num_views)};
}

}  // namespace

std::vector<Entry> BackendEntries(const std::string& model_text) {
  return {
      {"bundle_adjustment", [=] { return Adjustment(Scene(model_text)); }},
      {"stereo", [=] { return Stereo(Scene(model_text)); }},
      {"elevation", [] { return Elevation(); }},
      {"layers", [] { return Layers(); }},
      {"hazard_distance", [] { return Relimit(); }},
      {"approach", [] { return WindRose("approach", 1, {5.5}); }},
      {"wind_rose",
       [] {
         return WindRose("wind_rose", 72, {1.0, 2.5, 4.0, 5.5, 7.0});
       }},
  };
}

}  // namespace freelsd
