// Targets at known places, cameras above them, and a map that is wrong by a known height.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/evaluation/recorded/control_runs.h"

namespace freelsd {
namespace {

constexpr double kMapErrorM = 0.2;
constexpr double kMaxErrorM = 1e-3;

Camera SurveyCamera() {
  Camera camera;
  camera.width_px = 2000;
  camera.height_px = 1500;
  camera.fx_px = camera.fy_px = 1300.0;
  camera.cx_px = 999.5;
  camera.cy_px = 749.5;
  return camera;
}

// Seven targets by name; "seen once" by the first view alone, "hidden" by none.
std::map<std::string, Eigen::Vector3d> TargetsInWorld() {
  return {{"a", {-15.2, -10.2, 1.3}},
          {"b", {14.7, -12.4, 0.4}},
          {"c", {12.3, 13.6, 2.8}},
          {"d", {-13.4, 11.3, 0.1}},
          {"e", {1.2, 2.7, 5.2}},
          {"hidden", {5.4, 5.2, 1.0}},
          {"seen once", {-4.3, 6.3, 2.0}}};
}

struct Control {
  RecordedFlight flight{LocalFrame({54.5, -2.75, 0.0}), SurveyCamera(), {}, {}, {}};
  ElevationMap map;
  Targets targets;
  std::vector<TargetSighting> sightings;
};

// The grid is turned and somewhere else; its metres are those of world.
Control MakeControl() {
  Control control;
  AdjustedBlock& block = control.flight.block;
  block.camera = SurveyCamera();
  block.is_usable = true;
  for (const double east : {-12.0, 0.0, 12.0}) {
    AdjustedView view;
    view.frame_id = "view " + std::to_string(block.views.size());
    view.world_from_camera = {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {east, 1.0, 80.0}};
    view.is_connected = true;
    view.group = 0;
    block.views.push_back(view);
  }
  control.map.grid = GridAround({-20.0, -20.0}, {20.0, 20.0}, 1.0);
  const cv::Size size(control.map.grid.num_cols, control.map.grid.num_rows);
  control.map.elevation = cv::Mat1f(size, std::nanf(""));
  control.map.standard_deviation = cv::Mat1f(size, 0.1f);
  const Rigid3d grid_from_world{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
      {351000.0, 513000.0, 260.0}};
  for (const auto& [name, place] : TargetsInWorld()) {
    control.targets[name] = grid_from_world * place;
    const auto cell = control.map.grid.CellAt(place.head<2>());
    control.map.elevation(*cell) = static_cast<float>(place.z() + kMapErrorM);
    for (const AdjustedView& view : block.views) {
      const bool is_first = &view == &block.views.front();
      if (name == "hidden" || (name == "seen once" && !is_first)) continue;
      const auto pixel =
          block.camera.ImageFromCamera(Inverse(view.world_from_camera) * place).value();
      control.sightings.push_back({view.frame_id, name, pixel});
    }
  }
  return control;
}

ControlErrors Compare(const Control& control) {
  return CompareWithTargets(control.flight, control.map, control.targets, control.sightings);
}

TEST_CASE("control points: the map's heights are checked apart at targets seen twice and once") {
  const ControlErrors errors = Compare(MakeControl());
  CHECK(errors.num_targets == 5);
  CHECK(errors.aligned_vertical_m < kMaxErrorM);
  CHECK(errors.map_seen_twice.num_targets == 5);
  CHECK(errors.map_seen_twice.num_known == 5);
  CHECK(std::abs(errors.map_seen_twice.rms_m - kMapErrorM) < kMaxErrorM);
  CHECK(errors.map_seen_once.num_targets == 1);
  CHECK(std::abs(errors.map_seen_once.largest_m - kMapErrorM) < kMaxErrorM);
  CHECK(errors.map.num_known == 7);
  CHECK(errors.map.num_beyond == 0);
}

TEST_CASE(
    "control points: a height beyond three stated deviations counts, an unknown one does not") {
  Control control = MakeControl();
  const auto cell_of = [&control](const char* name) {
    return control.map.grid.CellAt(TargetsInWorld().at(name).head<2>()).value();
  };
  control.map.elevation(cell_of("a")) += 0.3f;
  control.map.standard_deviation(cell_of("seen once")) = 0.05f;
  control.map.elevation(cell_of("b")) = std::nanf("");
  const ControlErrors errors = Compare(control);
  CHECK(errors.map_seen_twice.num_targets == 5);
  CHECK(errors.map_seen_twice.num_known == 4);
  CHECK(errors.map_seen_twice.num_beyond == 1);
  CHECK(std::abs(errors.map_seen_twice.largest_m - (kMapErrorM + 0.3)) < kMaxErrorM);
  CHECK(errors.map_seen_once.num_beyond == 1);
  CHECK(errors.map.num_beyond == 2);
}

TEST_CASE("control points: a target that is left out does not hide its own error") {
  Control control = MakeControl();
  // The survey of one target is wrong by a metre: its own height must show nearly all of it.
  control.targets.at("e").z() += 1.0;
  const ControlErrors errors = Compare(control);
  CHECK(errors.largest_vertical_m > 0.99);
  CHECK(errors.map_seen_twice.largest_m > 0.99 - kMapErrorM);
}

TEST_CASE("control runs: tolerances fall in equal factors, photographs are spread evenly") {
  const std::vector<ControlTrial> trials = PlanControlRuns(10, 54);
  REQUIRE(trials.size() == 10);
  CHECK(trials.front().function_tolerance ==
        doctest::Approx(AdjustmentOptions{}.function_tolerance));
  CHECK(trials.back().function_tolerance == doctest::Approx(1e-8));
  for (size_t i = 1; i < trials.size(); ++i) {
    CHECK(trials[i].function_tolerance < trials[i - 1].function_tolerance);
    CHECK(trials[i].left_out >= trials[i - 1].left_out + 5);
    CHECK(trials[i].left_out <= trials[i - 1].left_out + 6);
  }
  CHECK(trials.back().left_out < 54);
  CHECK(PlanControlRuns(1, 54).front().left_out == 27);
  CHECK_THROWS_AS(PlanControlRuns(0, 54), std::invalid_argument);
  CHECK_THROWS_AS(PlanControlRuns(3, 2), std::invalid_argument);
}

TEST_CASE("control runs: the table ends with median, largest and all heights beyond") {
  std::vector<ControlRun> runs(3);
  const double errors_m[] = {0.5, 0.1, 0.2};
  for (size_t i = 0; i < runs.size(); ++i) {
    runs[i].left_out_id = "image " + std::to_string(i);
    runs[i].errors.aligned_vertical_m = errors_m[i];
    runs[i].errors.map_seen_twice = {12, 10, errors_m[i], 1.0, static_cast<int>(i)};
  }
  const std::string table = ControlEnd(runs);
  const auto row_of = [&table](const std::string& start) {
    const size_t begin = table.find(start);
    REQUIRE(begin != std::string::npos);
    return table.substr(begin, table.find('\n', begin) - begin);
  };
  CHECK(row_of("| median").find(" 0.20 |") != std::string::npos);
  CHECK(row_of("| median").find(" 0.50 |") == std::string::npos);
  CHECK(row_of("| largest").find(" 0.50 |") != std::string::npos);
  // Nothing is known of the targets seen once.
  CHECK(row_of("| median").find(" - |") != std::string::npos);
  CHECK(table.find("3 of 30 (10.0 %) at targets seen twice") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
