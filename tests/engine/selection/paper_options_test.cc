// The preset of the published form, against the numbers of the paper.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

TEST_CASE("paper: the options are valid") { CHECK_NOTHROW(PaperOptions().Check()); }

TEST_CASE("paper: the polynomials of height give the published thresholds") {
  struct Row {
    double height_m, canny, edge_distance_px;
  };
  constexpr double kTolerance = 0.05;
  const SegmentationOptions options = PaperOptions().segmentation;
  CHECK(options.thresholds == SegmentationThresholds::kPaper);
  for (const Row& row : {Row{58, 42.7, 37.7},
                         Row{100, 33.0, 27.6},
                         Row{150, 26.0, 18.9},
                         Row{200, 22.4, 13.0},
                         Row{250, 21.1, 8.9},
                         Row{300, 20.7, 5.6}}) {
    CAPTURE(row.height_m);
    CHECK(std::abs(CannyThreshold(row.height_m, options) - row.canny) < kTolerance);
    CHECK(std::abs(MinEdgeDistancePx(row.height_m, options) - row.edge_distance_px) < kTolerance);
  }
  // Clamped to the range of the fit, and never negative.
  CHECK(CannyThreshold(30, options) == CannyThreshold(58, options));
  CHECK(CannyThreshold(382, options) == doctest::Approx(18.8).epsilon(0.005));
  CHECK(CannyThreshold(500, options) == CannyThreshold(382, options));
  CHECK(MinEdgeDistancePx(382, options) == 2.0);
}

TEST_CASE("paper: Eq. 1 gives the published numbers of Techpod in 5.5 m/s") {
  const Aircraft techpod = PaperAircraft(Aircraft{});
  CHECK(ApproachDistance(techpod, 5.5) == doctest::Approx(108.58).epsilon(1e-4));
  CHECK(LoiterRadius(techpod, 5.5) == doctest::Approx(178.9).epsilon(1e-3));
  CHECK(techpod.ground_roll_m == 0.0);
  CHECK(Aircraft{}.ground_roll_m > 0.0);
}

TEST_CASE("paper: the disc has Delta_TD and half a cell, however uncertain the map is") {
  ElevationMap map;
  map.grid.cell_size_m = 1.0;
  map.position_sd_m = 3.0;
  const double half_diagonal = std::sqrt(0.5);
  CHECK(RequiredHazardDistance(map, Aircraft{}, PaperOptions().approach) ==
        doctest::Approx(10.0 + half_diagonal));
  CHECK(RequiredHazardDistance(map, Aircraft{}, ApproachOptions{}) > 15.0);
}

TEST_CASE("paper: rates and counts are the published ones") {
  const PipelineOptions options = PaperOptions();
  CHECK(options.preset == Preset::kPaper);
  CHECK(options.backend.backend_period_frames == 150);
  CHECK(options.backend.num_backend_candidates == 1);
  CHECK(options.regions.max_num_regions == 20);
  CHECK(options.regions.min_num_observations == 10);
  CHECK(options.adjustment.min_num_track_connections == 30);
  CHECK(options.stereo.num_partners == 1);
}

TEST_CASE("paper: the shipped model votes over the 18 features, and the majority decides") {
  const auto path =
      std::filesystem::path(FREELSD_TEST_SOURCE_DIR) / "engine/classification/paper_model.yml";
  std::ifstream file(path, std::ios::binary);
  const Classifier classifier =
      Classifier::Parse(std::string(std::istreambuf_iterator<char>(file), {}));
  CHECK(classifier.feature_set() == FeatureSet::kPaper18);
  // No range check: features that no surface has are voted on too. Shares of 31 trees.
  for (const float value : {-1e6f, 0.0f, 50.0f, 1e6f}) {
    const double votes = 31.0 * classifier.Predict(std::vector<float>(18, value));
    CHECK(votes == doctest::Approx(std::round(votes)));
  }
}

}  // namespace
}  // namespace freelsd
