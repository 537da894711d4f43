#include <cmath>

#include <doctest/doctest.h>

#include "engine/approach/approach.h"
#include "tests/engine/approach/scene.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

constexpr double kPrintedDistanceM = 0.005;  // the paper's numbers are rounded
constexpr double kPrintedRadiusM = 0.05;

Aircraft Profile(const char* name) { return *AircraftProfile(name); }

TEST_CASE("approach: Techpod in 5.5 m/s has a final of 108.58 m and a circle of 178.9 m") {
  const Aircraft techpod = Profile("techpod");
  CHECK(std::abs(ApproachDistance(techpod, 5.5) - 108.58) < kPrintedDistanceM);
  CHECK(std::abs(LoiterRadius(techpod, 5.5) - 178.9) < kPrintedRadiusM);
}

TEST_CASE("approach: Techpod needs 172 m of final in calm air and 244 m with 5.5 m/s from behind") {
  const Aircraft techpod = Profile("techpod");
  CHECK(std::abs(ApproachDistance(techpod, 0.0) - 172.0) < 0.5);
  CHECK(std::abs(DownwindApproachDistance(techpod, 5.5) - 244.0) < 0.5);
}

TEST_CASE("approach: AtlantikSolar descends 10.93 m in 74 m, as in the paper's last experiment") {
  const Aircraft solar = Profile("atlantiksolar");
  const double slope = solar.approach_height_m / ApproachDistance(solar, 5.5);
  CHECK(std::abs(slope * 74.0 - 10.93) < 0.15);  // the paper's v_land is only known to be about 9
}

TEST_CASE("approach: a wind of v cos(gamma) / cos(crosswind uncertainty) leaves no final") {
  const Aircraft techpod = Profile("techpod");
  const double strongest = 13.0 * std::cos(RadFromDeg(4.0)) / std::cos(RadFromDeg(30.0));
  CHECK(std::abs(ApproachDistance(techpod, strongest)) < 1e-9);
  CHECK(ApproachDistance(techpod, strongest + 0.1) < 0.0);
}

TEST_CASE("approach: the loiter circle is closed, level, tangent to the final and on its side") {
  for (const auto direction : {LoiterDirection::kLeft, LoiterDirection::kRight}) {
    Approach approach;
    approach.heading = RadFromDeg(30.0);
    approach.loiter_radius = 50.0;
    approach.loiter_direction = direction;
    const Eigen::Vector2d forward = DirectionOf(approach.heading);
    const Eigen::Vector2d left(-forward.y(), forward.x());
    const double side = direction == LoiterDirection::kLeft ? 1.0 : -1.0;
    approach.approach_start_in_world = {10.0, 20.0, 32.0};
    const Eigen::Vector2d center = Eigen::Vector2d(10.0, 20.0) + side * 50.0 * left;
    approach.loiter_center_in_world = {center.x(), center.y(), 32.0};
    const std::vector<Eigen::Vector3d> polyline = LoiterPolyline(approach, 720);
    REQUIRE(polyline.size() == 721);
    CHECK((polyline.front() - approach.approach_start_in_world).norm() < 1e-9);
    CHECK((polyline.back() - polyline.front()).norm() < 1e-9);
    for (const Eigen::Vector3d& point : polyline) {
      CHECK(std::abs((point - approach.loiter_center_in_world).norm() - 50.0) < 1e-9);
      CHECK(point.z() == doctest::Approx(32.0));
    }
    // The circle is left along the heading of the final.
    const Eigen::Vector3d last_leg = polyline[720] - polyline[719];
    CHECK(last_leg.head<2>().normalized().dot(forward) > std::cos(RadFromDeg(0.5)));
    const Eigen::Vector3d first_leg = polyline[1] - polyline[0];
    CHECK(first_leg.head<2>().normalized().dot(forward) > std::cos(RadFromDeg(0.5)));
  }
}

TEST_CASE("approach: each option out of its bounds is refused by name") {
  using O = ApproachOptions;
  CHECK_NOTHROW(O().Check());
  CHECK(RefusalOf(&O::heading_step_deg, 0.0) ==
        "approach.heading_step_deg = 0: must be in [1, 180]");
  CHECK(IsRefused(&O::min_map_position_sd_m, -1.0, "map_position_sd"));
  CHECK(IsRefused(&O::path_step_m, 0.0, "path_step_m"));
  CHECK(IsRefused(&O::max_height_sd_m, NAN, "max_height_sd_m"));
  CHECK(IsRefused(&O::max_num_candidates, 0, "max_num_cand"));
  CHECK(RefusalOf(&O::max_num_reserve_candidates, -1) ==
        "approach.max_num_reserve_candidates = -1: must be in [0, 1e+06]");
  CHECK(RefusalOf(&O::path_margin_sigma, 11.0) ==
        "approach.path_margin_sigma = 11: must be in [0, 10]");
  CHECK(RefusalOf(&O::max_num_reserve_candidates, 0).empty());
  CHECK(RefusalOf(&O::path_margin_sigma, 0.0).empty());
  CHECK(IsRefused(&O::candidate_spacing_m, -1.0, "spacing"));
  CHECK(IsRefused(&O::calm_wind_mps, -1.0, "calm_wind_mps"));
  CHECK(IsRefused(&O::unknown_wind_mps, -1.0, "unknown_wind"));
  CHECK(IsRefused(&O::max_num_rejections, -1, "rejections"));
  CHECK(IsRefused(&O::unclear_height_allowance_m, -2.0, "allow"));
  CHECK(RefusalOf(&O::start_height_ratios, {1.0}).empty());
  CHECK(RefusalOf(&O::start_height_ratios, {}) ==
        "approach.start_height_ratios = 0 numbers: must be 1 to 10");
  for (const std::vector<double>& ratios : {std::vector<double>(11, 1.0),
                                            std::vector<double>{2.0, 1.0},
                                            std::vector<double>{1.0, 21.0},
                                            std::vector<double>{std::nan("")}}) {
    CHECK(IsRefused(&O::start_height_ratios, ratios, "start_height_ratios"));
  }
}

}  // namespace
}  // namespace freelsd
