#include "engine/cover/kind/kind.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

TEST_CASE("kind: a cue is linear between its knots and constant beyond them") {
  const CueTerm term{Cue::kRoughness, {1.0f, 2.0f, 4.0f}, {-1.0f, 1.0f, 0.0f}, 0.25f};
  CHECK(term.At(0.0f) == -1.0f);
  CHECK(term.At(1.5f) == doctest::Approx(0.0));
  CHECK(term.At(2.0f) == 1.0f);
  CHECK(term.At(3.0f) == doctest::Approx(0.5));
  CHECK(term.At(9.0f) == 0.0f);
  CHECK(term.At(kUnknown) == 0.25f);
}

TEST_CASE("kind: no score gets more than ground that was left out has earned") {
  const KindModel model{0.0f, {}, {{-1.0f, 0.2f}, {2.0f, 0.9f}}};
  CHECK(model.Probability(-1.5f) == 0.0f);
  CHECK(model.Probability(1.9f) == 0.2f);
  CHECK(model.Probability(50.0f) == 0.9f);
}

// A plane of 40 m seen from nowhere: only heights are known.
ElevationMap FlatMap() {
  ElevationMap map;
  map.grid = {{0.0, 40.0}, 1.0, 40, 40};
  map.elevation = cv::Mat1f(40, 40, 5.0f);
  map.upper = cv::Mat1f(40, 40, 5.1f);
  map.standard_deviation = cv::Mat1f(40, 40, 0.1f);
  map.num_points = cv::Mat1f(40, 40, 9.0f);
  return map;
}

TEST_CASE("kind: known cues add to the offset, and unknown cues what stands for them") {
  ElevationMap map = FlatMap();
  map.upper(10, 10) = 7.0f;
  map.elevation(20, 20) = kUnknown;
  const GroundSurface surface = MeasureSurface(map, {});
  const KindModel model{0.5f,
                        {{Cue::kCoverHeight, {0.0f, 1.0f}, {1.0f, -3.0f}, -5.0f},
                         {Cue::kViewLogOdds, {-1.0f, 1.0f}, {-2.0f, 2.0f}, -0.25f}},
                        {}};
  const cv::Mat1f scores = KindScores({map, surface, {}, {}}, {}, model);
  CHECK(scores(5, 5) == doctest::Approx(0.5 + 0.6 - 0.25));
  // The height is a mean over 25 cells: 24 of 0.1 m and one of 2 m.
  CHECK(scores(10, 10) == doctest::Approx(0.5 + 1.0 - 4.0 * 0.176 - 0.25).epsilon(1e-3));
  CHECK(std::isnan(scores(20, 20)));
}

TEST_CASE("kind: in the shipped model probabilities rise with the score and stay below one") {
  const KindModel& model = ShippedKindModel();
  REQUIRE_FALSE(model.terms.empty());
  REQUIRE_FALSE(model.earned.empty());
  for (size_t i = 1; i < model.earned.size(); ++i) {
    CHECK(model.earned[i].min_score > model.earned[i - 1].min_score);
    CHECK(model.earned[i].probability >= model.earned[i - 1].probability);
  }
  CHECK(model.earned.back().probability < 1.0f);
  for (const CueTerm& term : model.terms) {
    CHECK(term.knots.size() == term.log_odds.size());
    CHECK(std::is_sorted(term.knots.begin(), term.knots.end()));
  }
}

TEST_CASE("kind: the shipped model calls nothing grass that no photograph shows") {
  const ElevationMap map = FlatMap();
  const GroundSurface surface = MeasureSurface(map, {});
  CoverOptions options;
  options.cover_method = CoverMethod::kEvidence;
  const GroundCover cover = AssessCover(map, surface, {}, options);
  CHECK(cv::countNonZero(cover.grass >= options.min_grass_posterior) == 0);
}

}  // namespace
}  // namespace freelsd
