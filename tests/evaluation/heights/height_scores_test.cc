#include "tests/evaluation/heights/height_scores.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/evaluation/heights/height_totals.h"

namespace freelsd {
namespace {

constexpr int kSizeM = 60;
constexpr int kNumCells = kSizeM * kSizeM;
// Heights of the map are floats.
constexpr double kRoundingM = 1e-4;

// A flat meadow, all of it photographed, and a map of it without error.
struct Meadow {
  Scenario scenario;
  ElevationMap map;
  HazardLayers layers;

  Meadow() {
    WorldOptions options;
    options.size_m = kSizeM;
    options.cell_size_m = 0.2;
    scenario.world = MakeMeadowPlane(options);
    scenario.aircraft = AircraftProfile("small").value();
    scenario.frame_spacing_m = 13.0;
    scenario.seen = cv::Mat1b(kSizeM, kSizeM, uint8_t{255});
    map.grid = {{-0.5 * kSizeM, 0.5 * kSizeM}, 1.0, kSizeM, kSizeM};
    map.elevation = cv::Mat1f(kSizeM, kSizeM);
    map.upper = cv::Mat1f(kSizeM, kSizeM);
    map.standard_deviation = cv::Mat1f(kSizeM, kSizeM, 0.1f);
    layers.grid = map.grid;
    layers.roughness = cv::Mat1f(kSizeM, kSizeM, 0.05f);
    layers.hazard = cv::Mat1b(kSizeM, kSizeM, uint8_t{kFree});
    SetErrors([](int, int) { return 0.0; });
  }
  // Of each cell of the map, by row and column.
  template <typename Error>
  void SetErrors(Error error) {
    for (int row = 0; row < kSizeM; ++row) {
      for (int col = 0; col < kSizeM; ++col) {
        const Eigen::Vector2d place = map.grid.CellCenter(row, col);
        map.elevation(row, col) = static_cast<float>(
            scenario.world.SurfaceHeight(place.x(), place.y()) + error(row, col));
      }
    }
    map.upper = map.elevation.clone();
  }
  HeightScores Scores() const {
    return ScoreHeights(map, layers, scenario, MakeTruthMap(scenario.world, scenario.aircraft));
  }
};

// 0.1 m up and down in turns.
double Chequered(int row, int col) { return (row + col) % 2 == 0 ? 0.1 : -0.1; }

TEST_CASE("heights: a tilted and lifted map is right without its plane, not without its shift") {
  constexpr double kGradient = 0.02;
  Meadow meadow;
  meadow.SetErrors([](int, int col) { return 1.0 + kGradient * col; });
  const HeightScores scores = meadow.Scores();
  CHECK(scores.plane_off.at("all").errors.count == kNumCells);
  CHECK(scores.plane_off.at("all").errors.Rms() < kRoundingM);
  // Of the numbers 1 to n the deviation is sqrt((n^2 - 1) / 12).
  const double expected_m = kGradient * std::sqrt((kSizeM * kSizeM - 1.0) / 12.0);
  CHECK(scores.shift_off.at("all").errors.Sd() == doctest::Approx(expected_m).epsilon(0.01));
  CHECK(scores.num_open == kNumCells);
  CHECK(scores.num_unknown == 0);
}

TEST_CASE("heights: errors beyond what is told are counted, and stand beside it in the table") {
  Meadow meadow;
  meadow.SetErrors(Chequered);
  meadow.map.standard_deviation.setTo(0.04f);
  const HeightScores scores = meadow.Scores();
  const HeightErrors& all = scores.plane_off.at("all");
  CHECK(all.num_beyond_2 == kNumCells);
  CHECK(all.num_beyond_3 == 0);
  CHECK(all.sizes.Percentile(50.0) == doctest::Approx(0.1).epsilon(0.06));
  CHECK(all.largest == doctest::Approx(0.1).epsilon(0.01));
  CHECK(scores.steps.Percentile(99.0) == doctest::Approx(0.2).epsilon(0.03));
  CHECK(scores.by_told[0].told.count == kNumCells);
  CHECK(scores.by_told[0].told.Rms() == doctest::Approx(0.04));
  CHECK(scores.by_told[0].errors.Rms() == doctest::Approx(0.1).epsilon(0.01));
  meadow.map.standard_deviation.setTo(2.0f);
  CHECK(meadow.Scores().by_told.back().told.count == kNumCells);
}

TEST_CASE("heights: a hole in the midst of known ground is scattered, the map's end is not") {
  constexpr int kNumUnknownRows = 6;
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  Meadow meadow;
  meadow.map.elevation(30, 30) = kUnknown;
  meadow.map.elevation.rowRange(0, kNumUnknownRows).setTo(kUnknown);
  const HeightScores scores = meadow.Scores();
  CHECK(scores.num_unknown == 1 + kNumUnknownRows * kSizeM);
  CHECK(scores.num_scattered == 1);
  // The map's first rows are the northern ones, the truth's last.
  meadow.scenario.seen.rowRange(kSizeM - kNumUnknownRows, kSizeM).setTo(0);
  const HeightScores of_seen = meadow.Scores();
  CHECK(of_seen.num_unknown == 1);
  CHECK(of_seen.num_open == kNumCells - kNumUnknownRows * kSizeM);
}

TEST_CASE("heights: an error beside a tree counts near what is tall, one elsewhere far from it") {
  Meadow meadow;
  const Tree tree{.center = {0.5, 0.5}, .height_m = 14.0};
  meadow.scenario.world.Plant(tree);
  const auto cell_at = [&](double east_of_crown_m) {
    return meadow.map.grid.CellAt({0.5 + tree.radius_m + east_of_crown_m, 0.5}).value();
  };
  const cv::Point beside = cell_at(1.5), away = cell_at(8.0);
  meadow.SetErrors([&](int row, int col) {
    if (cv::Point(col, row) == beside) return 1.0;
    return cv::Point(col, row) == away ? 0.5 : 0.0;
  });
  const HeightScores scores = meadow.Scores();
  CHECK(scores.shift_off.at("near").largest == doctest::Approx(1.0).epsilon(0.01));
  CHECK(scores.shift_off.at("far").largest == doctest::Approx(0.5).epsilon(0.01));
  CHECK(scores.shift_off.at("near").errors.count > 20);
  CHECK(scores.shift_off.at("far").errors.count > kNumCells / 2);
  // Cells of the crown are no open ground.
  CHECK(scores.num_open < kNumCells);
}

TEST_CASE("heights: landable ground that looks rough is counted, whatever makes it a hazard") {
  Meadow meadow;
  const cv::Rect rough(20, 20, 10, 10);
  meadow.layers.roughness(rough).setTo(meadow.scenario.aircraft.max_roughness_m + 0.1);
  meadow.layers.hazard(rough & cv::Rect(20, 20, 5, 10)).setTo(kHazard);
  const HeightScores scores = meadow.Scores();
  CHECK(scores.num_landable > kNumCells / 2);
  CHECK(scores.num_looking_rough == 100);
  CHECK(scores.num_rough_hazards == 50);
}

TEST_CASE("heights: no map, no figures") {
  Meadow meadow;
  meadow.map = {};
  meadow.layers = {};
  const HeightScores scores = meadow.Scores();
  CHECK(scores.num_unknown == kNumCells);
  const nlohmann::json figures = HeightFigures(scores);
  CHECK(figures.at("median_m").is_null());
  CHECK(figures.at("unknown_ratio") == 1.0);
}

TEST_CASE("heights: worlds are pooled by their cells, and the bad one is named besides") {
  Meadow good, bad;
  bad.SetErrors(Chequered);
  const auto record = [](const Meadow& meadow, double spacing_m) {
    return nlohmann::json{{"spacing_m", spacing_m}, {"heights", HeightRecord(meadow.Scores())}};
  };
  // As a file has them.
  const nlohmann::json records =
      nlohmann::json::parse(nlohmann::json{record(good, 6.0), record(bad, 13.0)}.dump());
  const nlohmann::json totals = HeightTotals(records);
  CHECK(totals.at("num_cells") == 2 * kNumCells);
  CHECK(totals.at("rms_m").get<double>() == doctest::Approx(0.1 / std::sqrt(2.0)).epsilon(0.01));
  CHECK(totals.at("median_m").get<double>() < 0.006);
  CHECK(totals.at("p95_m").get<double>() == doctest::Approx(0.1).epsilon(0.06));
  CHECK(totals.at("worlds_median_m").at("largest").get<double>() ==
        doctest::Approx(0.1).epsilon(0.06));
  CHECK(totals.at("by_spacing").size() == 2);
  CHECK(totals.at("by_spacing").at("  6 m apart").at("num_cells") == kNumCells);
  CHECK(HeightTotals(nlohmann::json::array()).empty());
}

}  // namespace
}  // namespace freelsd
