#include "tests/evaluation/heights/height_scores.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "tests/evaluation/scores/elevation_error.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kMinFreeDistanceM = 2.0;
// Half the side of the square around an unknown cell, and the share of it that is known around a
// hole.
constexpr int kHoleReach = 2;
constexpr double kKnownAroundHole = 0.7;

// What the map says of every cell of the truth: row 0 south.
struct Heights {
  // Estimate less truth; NaN where the map is unknown.
  cv::Mat1d error;
  cv::Mat1d told_sd;
  // Open ground that three photographs see.
  cv::Mat1b is_open;
};

bool IsKnown(const ElevationMap& map, const Eigen::Vector2d& place) {
  const std::optional<cv::Point> cell = map.grid.CellAt(place);
  return cell && map.IsSeen(cell->y, cell->x);
}

Heights CompareHeights(const ElevationMap& map, const Scenario& scenario, const TruthMap& truth) {
  const cv::Size size = truth.cover.size();
  Heights heights{cv::Mat1d(size, kUnknown), cv::Mat1d(size, kUnknown), cv::Mat1b::zeros(size)};
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const bool is_open = IsOpenGround(static_cast<Cover>(truth.cover(row, col)));
      if (!is_open || scenario.seen(row, col) == 0) continue;
      heights.is_open(row, col) = 1;
      const Eigen::Vector2d place = truth.CellCenter(row, col);
      if (!IsKnown(map, place)) continue;
      const cv::Point cell = map.grid.CellAt(place).value();
      const Eigen::Vector2d center = map.grid.CellCenter(cell.y, cell.x);
      heights.error(row, col) =
          map.elevation(cell) - scenario.world.SurfaceHeight(center.x(), center.y());
      heights.told_sd(row, col) = map.standard_deviation(cell);
    }
  }
  return heights;
}

// Cells within kNearM of what stands kTallM high.
cv::Mat1b NearTallThings(const World& world, const TruthMap& truth) {
  cv::Mat1b is_low(truth.top.size(), uint8_t{1});
  for (int row = 0; row < is_low.rows; ++row) {
    for (int col = 0; col < is_low.cols; ++col) {
      const Eigen::Vector2d place = truth.CellCenter(row, col);
      const double height = truth.top(row, col) - world.GroundHeight(place.x(), place.y());
      is_low(row, col) = height < HeightScores::kTallM;
    }
  }
  cv::Mat1f distance;
  cv::distanceTransform(is_low, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * truth.cell_size_m <= HeightScores::kNearM;
}

std::vector<HeightError> ErrorsOf(const Heights& heights, const TruthMap& truth) {
  std::vector<HeightError> errors;
  for (int row = 0; row < heights.error.rows; ++row) {
    for (int col = 0; col < heights.error.cols; ++col) {
      const double error = heights.error(row, col);
      if (std::isfinite(error)) errors.push_back({truth.CellCenter(row, col), error});
    }
  }
  return errors;
}

double MedianOf(const std::vector<HeightError>& errors) {
  std::vector<double> values;
  values.reserve(errors.size());
  for (const HeightError& each : errors) values.push_back(each.error);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Mat1d WithoutPlane(const Heights& heights, const TruthMap& truth, const ErrorPlane& plane) {
  cv::Mat1d left = heights.error.clone();
  for (int row = 0; row < left.rows; ++row) {
    for (int col = 0; col < left.cols; ++col)
      left(row, col) -= plane.At(truth.CellCenter(row, col));
  }
  return left;
}

void AddErrors(std::map<std::string, HeightErrors>& by_place,
               const cv::Mat1d& errors,
               const Heights& heights,
               const cv::Mat1b& is_near) {
  HeightErrors& far = by_place["far"];
  HeightErrors& near = by_place["near"];
  for (int row = 0; row < errors.rows; ++row) {
    for (int col = 0; col < errors.cols; ++col) {
      if (!std::isfinite(errors(row, col))) continue;
      (is_near(row, col) != 0 ? near : far).Add(errors(row, col), heights.told_sd(row, col));
    }
  }
  HeightErrors& all = by_place["all"];
  all.Add(far);
  all.Add(near);
}

void AddTold(HeightScores& scores, const cv::Mat1d& errors, const Heights& heights) {
  const auto& edges = HeightScores::kToldEdges;
  for (int row = 0; row < errors.rows; ++row) {
    for (int col = 0; col < errors.cols; ++col) {
      const double told = heights.told_sd(row, col);
      if (!std::isfinite(errors(row, col)) || !(told >= 0.0)) continue;
      const auto bin = std::upper_bound(edges.begin(), edges.end(), told) - edges.begin() - 1;
      ToldDeviations& counts = scores.by_told[static_cast<size_t>(bin)];
      counts.told.Add(told);
      counts.errors.Add(errors(row, col));
    }
  }
}

void AddSteps(HeightScores& scores, const cv::Mat1d& errors, const cv::Mat1b& is_near) {
  const auto add = [&](const cv::Point& cell, const cv::Point& neighbour) {
    if (neighbour.x >= errors.cols || neighbour.y >= errors.rows) return;
    const double step = std::abs(errors(cell) - errors(neighbour));
    scores.steps.Add(step);
    if (is_near(cell) == 0 && is_near(neighbour) == 0) scores.steps_far.Add(step);
  };
  for (int row = 0; row < errors.rows; ++row) {
    for (int col = 0; col < errors.cols; ++col) {
      add({col, row}, {col + 1, row});
      add({col, row}, {col, row + 1});
    }
  }
}

bool IsHole(const ElevationMap& map, const Eigen::Vector2d& place) {
  int num_known = 0, num_others = -1;
  for (int i = -kHoleReach; i <= kHoleReach; ++i) {
    for (int j = -kHoleReach; j <= kHoleReach; ++j) {
      ++num_others;
      num_known += IsKnown(map, place + map.grid.cell_size_m * Eigen::Vector2d(i, j));
    }
  }
  return num_known > kKnownAroundHole * num_others;
}

void AddUnknown(HeightScores& scores,
                const Heights& heights,
                const ElevationMap& map,
                const TruthMap& truth) {
  for (int row = 0; row < heights.error.rows; ++row) {
    for (int col = 0; col < heights.error.cols; ++col) {
      if (heights.is_open(row, col) == 0) continue;
      ++scores.num_open;
      if (std::isfinite(heights.error(row, col))) continue;
      ++scores.num_unknown;
      scores.num_scattered += IsHole(map, truth.CellCenter(row, col));
    }
  }
}

void AddRoughness(HeightScores& scores,
                  const HazardLayers& layers,
                  const Scenario& scenario,
                  const TruthMap& truth) {
  for (int row = 0; row < truth.fault.rows; ++row) {
    for (int col = 0; col < truth.fault.cols; ++col) {
      if (scenario.seen(row, col) == 0 || truth.free_distance(row, col) <= kMinFreeDistanceM)
        continue;
      const auto cell = layers.grid.CellAt(truth.CellCenter(row, col));
      if (!cell || !std::isfinite(layers.roughness(*cell))) continue;
      const bool looks_rough = layers.roughness(*cell) > scenario.aircraft.max_roughness_m;
      ++scores.num_landable;
      scores.num_looking_rough += looks_rough;
      scores.num_rough_hazards += looks_rough && layers.hazard(*cell) == kHazard;
    }
  }
}

void AddAll(std::map<std::string, HeightErrors>& total,
            const std::map<std::string, HeightErrors>& others) {
  for (const auto& [place, errors] : others) total[place].Add(errors);
}

Json ToJson(const HeightErrors& errors) {
  return {{"errors", ToJson(errors.errors)},
          {"sizes", errors.sizes.ToJson()},
          {"largest", errors.largest},
          {"num_told", errors.num_told},
          {"num_beyond_2", errors.num_beyond_2},
          {"num_beyond_3", errors.num_beyond_3}};
}

Json ToJson(const std::map<std::string, HeightErrors>& by_place) {
  Json json = Json::object();
  for (const auto& [place, errors] : by_place) json[place] = ToJson(errors);
  return json;
}

std::map<std::string, HeightErrors> ErrorsFromJson(const Json& json) {
  std::map<std::string, HeightErrors> by_place;
  for (const auto& [place, errors] : json.items()) {
    by_place[place] = {SumsFromJson(errors.at("errors")),
                       FineHistogram::FromJson(errors.at("sizes")),
                       errors.at("largest").get<double>(),
                       errors.at("num_told").get<int64_t>(),
                       errors.at("num_beyond_2").get<int64_t>(),
                       errors.at("num_beyond_3").get<int64_t>()};
  }
  return by_place;
}

struct NamedCount {
  const char* name;
  int64_t HeightScores::*count;
};
constexpr std::array<NamedCount, 6> kCounts{
    {{"num_open", &HeightScores::num_open},
     {"num_unknown", &HeightScores::num_unknown},
     {"num_scattered", &HeightScores::num_scattered},
     {"num_landable", &HeightScores::num_landable},
     {"num_looking_rough", &HeightScores::num_looking_rough},
     {"num_rough_hazards", &HeightScores::num_rough_hazards}}};

}  // namespace

void HeightErrors::Add(double error, double told_sd) {
  const double size = std::abs(error);
  errors.Add(error);
  sizes.Add(size);
  largest = std::max(largest, size);
  if (!std::isfinite(told_sd)) return;
  ++num_told;
  num_beyond_2 += size > 2.0 * told_sd;
  num_beyond_3 += size > 3.0 * told_sd;
}

void HeightErrors::Add(const HeightErrors& other) {
  errors.Add(other.errors);
  sizes.Add(other.sizes);
  largest = std::max(largest, other.largest);
  num_told += other.num_told;
  num_beyond_2 += other.num_beyond_2;
  num_beyond_3 += other.num_beyond_3;
}

void ToldDeviations::Add(const ToldDeviations& other) {
  told.Add(other.told);
  errors.Add(other.errors);
}

void HeightScores::Add(const HeightScores& other) {
  AddAll(plane_off, other.plane_off);
  AddAll(shift_off, other.shift_off);
  for (size_t i = 0; i < by_told.size(); ++i) by_told[i].Add(other.by_told[i]);
  steps.Add(other.steps);
  steps_far.Add(other.steps_far);
  for (const auto& [name, count] : kCounts) this->*count += other.*count;
}

HeightScores ScoreHeights(const ElevationMap& map,
                          const HazardLayers& layers,
                          const Scenario& scenario,
                          const TruthMap& truth) {
  HeightScores scores;
  const Heights heights = CompareHeights(map, scenario, truth);
  AddUnknown(scores, heights, map, truth);
  const std::vector<HeightError> errors = ErrorsOf(heights, truth);
  if (errors.empty()) return scores;
  const cv::Mat1b is_near = NearTallThings(scenario.world, truth);
  const cv::Mat1d without_plane = WithoutPlane(heights, truth, FitErrorPlane(errors));
  AddErrors(scores.plane_off, without_plane, heights, is_near);
  AddErrors(scores.shift_off, heights.error - MedianOf(errors), heights, is_near);
  AddTold(scores, without_plane, heights);
  AddSteps(scores, without_plane, is_near);
  AddRoughness(scores, layers, scenario, truth);
  return scores;
}

Json ToJson(const HeightScores& scores) {
  Json json{{"plane_off", ToJson(scores.plane_off)},
            {"shift_off", ToJson(scores.shift_off)},
            {"by_told", Json::array()},
            {"steps", scores.steps.ToJson()},
            {"steps_far", scores.steps_far.ToJson()}};
  for (const ToldDeviations& each : scores.by_told) {
    json["by_told"].push_back({ToJson(each.told), ToJson(each.errors)});
  }
  for (const auto& [name, count] : kCounts) json[name] = scores.*count;
  return json;
}

HeightScores HeightScoresFromJson(const Json& json) {
  HeightScores scores;
  scores.plane_off = ErrorsFromJson(json.at("plane_off"));
  scores.shift_off = ErrorsFromJson(json.at("shift_off"));
  for (size_t i = 0; i < scores.by_told.size(); ++i) {
    const Json& bin = json.at("by_told").at(i);
    scores.by_told[i] = {SumsFromJson(bin.at(0)), SumsFromJson(bin.at(1))};
  }
  scores.steps = FineHistogram::FromJson(json.at("steps"));
  scores.steps_far = FineHistogram::FromJson(json.at("steps_far"));
  for (const auto& [name, count] : kCounts) scores.*count = json.at(name).get<int64_t>();
  return scores;
}

}  // namespace freelsd
