// What the stages of the engine made of one flight, as numbers that another processor can be
// compared with.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

struct StageRecord {
  std::string stage;
  // Names the unit too: "height, m".
  std::string quantity;
  // In an order that does not depend on the processor.
  std::vector<double> values;
};
// In the order of the method.
using StageRecords = std::vector<StageRecord>;

// All elements, row by row.
StageRecord RecordOf(const std::string& stage, const std::string& quantity, const cv::Mat& raster);

// The bits of every value are kept. Throws std::runtime_error if the file cannot be written or
// read.
void WriteRecords(const std::string& path, const StageRecords& records);
StageRecords ReadRecords(const std::string& path);

struct StageDifference {
  std::string stage;
  std::string quantity;
  // Of both; if they differ, nothing else is compared.
  size_t num_values_a = 0;
  size_t num_values_b = 0;
  // Values whose bits differ. Two unknown values (NaN) are equal.
  size_t num_unequal = 0;
  // Known in one and unknown in the other.
  size_t num_known_in_one = 0;
  // Over the values that are known in both.
  double largest = 0.0;
  double root_mean_square = 0.0;

  bool IsEqual() const { return num_values_a == num_values_b && num_unequal == 0; }
};
// One for each record of `a`, compared with the record of `b` at the same place. Throws
// std::invalid_argument if the stages or their quantities are not the same.
std::vector<StageDifference> Compare(const StageRecords& a, const StageRecords& b);

}  // namespace freelsd
