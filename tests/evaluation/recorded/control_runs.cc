#include "tests/evaluation/recorded/control_runs.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr double kFirstTolerance = 1e-4;
constexpr double kLastTolerance = 1e-8;

struct Column {
  const char* heading;
  int num_digits;
  double (*value)(const ControlRun&);
};

double BeyondPercent(const HeightChecks& checks) {
  if (checks.num_known == 0) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * checks.num_beyond / checks.num_known;
}

using Run = const ControlRun&;
constexpr std::array<Column, 18> kColumns{{
    {"in one block", 0, [](Run run) { return static_cast<double>(run.num_in_block); }},
    {"seen twice", 0, [](Run run) { return 1.0 * run.errors.num_targets; }},
    {"horizontal m", 2, [](Run run) { return run.errors.aligned_horizontal_m; }},
    {"largest", 2, [](Run run) { return run.errors.largest_horizontal_m; }},
    {"vertical m", 2, [](Run run) { return run.errors.aligned_vertical_m; }},
    {"largest", 2, [](Run run) { return run.errors.largest_vertical_m; }},
    {"map at those seen twice",
     0,
     [](Run run) { return 1.0 * run.errors.map_seen_twice.num_known; }},
    {"RMS m", 2, [](Run run) { return run.errors.map_seen_twice.rms_m; }},
    {"largest", 2, [](Run run) { return run.errors.map_seen_twice.largest_m; }},
    {"beyond 3 sd, %", 0, [](Run run) { return BeyondPercent(run.errors.map_seen_twice); }},
    {"seen once", 0, [](Run run) { return 1.0 * run.errors.map_seen_once.num_targets; }},
    {"map at them", 0, [](Run run) { return 1.0 * run.errors.map_seen_once.num_known; }},
    {"RMS m", 2, [](Run run) { return run.errors.map_seen_once.rms_m; }},
    {"largest", 2, [](Run run) { return run.errors.map_seen_once.largest_m; }},
    {"beyond 3 sd, %", 0, [](Run run) { return BeyondPercent(run.errors.map_seen_once); }},
    {"map at all RMS m", 2, [](Run run) { return run.errors.map.rms_m; }},
    {"beyond 3 sd, %", 0, [](Run run) { return BeyondPercent(run.errors.map); }},
    {"seconds", 1, [](Run run) { return run.seconds; }},
}};

std::string Number(double value, int num_digits) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", num_digits, value);
  return text;
}

// Of the values that are known.
double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double Largest(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return *std::max_element(values.begin(), values.end());
}

std::string RowOf(const std::string& name,
                  const std::vector<ControlRun>& runs,
                  const std::function<double(const std::vector<double>&)>& choose) {
  std::string row = name;
  for (const Column& column : kColumns) {
    std::vector<double> values;
    for (const ControlRun& run : runs) {
      const double value = column.value(run);
      if (!std::isnan(value)) values.push_back(value);
    }
    row += " " + Number(choose(values), column.num_digits) + " |";
  }
  return row + "\n";
}

std::string SumOfBeyond(const std::vector<ControlRun>& runs,
                        const HeightChecks ControlErrors::*checks) {
  int num_beyond = 0, num_known = 0;
  for (const ControlRun& run : runs) {
    num_beyond += (run.errors.*checks).num_beyond;
    num_known += (run.errors.*checks).num_known;
  }
  const double percent = 100.0 * num_beyond / std::max(1, num_known);
  return std::to_string(num_beyond) + " of " + std::to_string(num_known) + " (" +
         Number(percent, 1) + " %)";
}

}  // namespace

std::vector<ControlTrial> PlanControlRuns(size_t num_runs, size_t num_photographs) {
  if (num_runs < 1 || num_runs > num_photographs) {
    throw std::invalid_argument("control runs = " + std::to_string(num_runs) + ": must be in [1, " +
                                std::to_string(num_photographs) + "]");
  }
  std::vector<ControlTrial> trials;
  for (size_t i = 0; i < num_runs; ++i) {
    const double share = num_runs == 1 ? 0.0 : static_cast<double>(i) / (num_runs - 1.0);
    trials.push_back({kFirstTolerance * std::pow(kLastTolerance / kFirstTolerance, share),
                      (2 * i + 1) * num_photographs / (2 * num_runs)});
  }
  return trials;
}

ControlRun RunControl(const ControlFlight& flight,
                      const ControlTrial& trial,
                      const GroundModel& ground_model,
                      PipelineOptions options) {
  options.adjustment.function_tolerance = trial.function_tolerance;
  RecordedFrames recorded = flight.recorded;
  const auto left_out = recorded.frames.begin() + static_cast<std::ptrdiff_t>(trial.left_out);
  ControlRun run{trial, left_out->id, 0, {}, 0.0};
  recorded.frames.erase(left_out);
  const auto start = std::chrono::steady_clock::now();
  const RecordedFlight adjusted = AdjustRecordedFlight(recorded, ground_model, options);
  const ElevationMap map = MapOfBlock(adjusted, options);
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.num_in_block = adjusted.block.LargestGroup().size();
  run.errors = CompareWithTargets(adjusted, map, flight.targets, flight.sightings);
  return run;
}

std::string ControlHeading() {
  std::string heading = "| tolerance | without |", line = "|---|---|";
  for (const Column& column : kColumns) {
    heading += " " + std::string(column.heading) + " |";
    line += "---|";
  }
  return heading + "\n" + line + "\n";
}

std::string ControlRow(const ControlRun& run) {
  char tolerance[32];
  std::snprintf(tolerance, sizeof tolerance, "%.1e", run.trial.function_tolerance);
  return RowOf("| " + std::string(tolerance) + " | " + run.left_out_id + " |", {run}, Largest);
}

std::string ControlEnd(const std::vector<ControlRun>& runs) {
  return RowOf("| median | |", runs, Median) + RowOf("| largest | |", runs, Largest) +
         "\nHeights of the map beyond three stated deviations, all runs: " +
         SumOfBeyond(runs, &ControlErrors::map_seen_twice) + " at targets seen twice, " +
         SumOfBeyond(runs, &ControlErrors::map_seen_once) + " at targets seen once, " +
         SumOfBeyond(runs, &ControlErrors::map) + " at all targets.\n";
}

}  // namespace freelsd
