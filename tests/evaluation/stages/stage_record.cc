#include "tests/evaluation/stages/stage_record.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>

namespace freelsd {
namespace {

void WriteCount(std::ofstream& file, size_t count) {
  const auto number = static_cast<uint64_t>(count);
  file.write(reinterpret_cast<const char*>(&number), sizeof(number));
}

void WriteText(std::ofstream& file, const std::string& text) {
  WriteCount(file, text.size());
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
}

size_t ReadCount(std::ifstream& file) {
  uint64_t number = 0;
  file.read(reinterpret_cast<char*>(&number), sizeof(number));
  return static_cast<size_t>(number);
}

std::string ReadText(std::ifstream& file) {
  std::string text(ReadCount(file), ' ');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

void Add(double a, double b, StageDifference& difference) {
  if (std::isnan(a) && std::isnan(b)) return;
  if (std::isnan(a) || std::isnan(b)) {
    ++difference.num_unequal;
    ++difference.num_known_in_one;
    return;
  }
  if (a == b) return;
  ++difference.num_unequal;
  difference.largest = std::max(difference.largest, std::abs(a - b));
  difference.root_mean_square += (a - b) * (a - b);
}

StageDifference DifferenceOf(const StageRecord& a, const StageRecord& b) {
  if (a.stage != b.stage || a.quantity != b.quantity) {
    throw std::invalid_argument("stages: " + a.stage + " of one file stands where the other has " +
                                b.stage);
  }
  StageDifference difference{a.stage, a.quantity, a.values.size(), b.values.size()};
  if (a.values.size() != b.values.size()) return difference;
  for (size_t i = 0; i < a.values.size(); ++i) Add(a.values[i], b.values[i], difference);
  const size_t num_known = a.values.size() - difference.num_known_in_one;
  if (num_known > 0) {
    difference.root_mean_square =
        std::sqrt(difference.root_mean_square / static_cast<double>(num_known));
  }
  return difference;
}

}  // namespace

StageRecord RecordOf(const std::string& stage, const std::string& quantity, const cv::Mat& raster) {
  if (raster.empty()) return {stage, quantity, {}};
  cv::Mat1d values;
  raster.reshape(1).convertTo(values, CV_64F);
  return {stage, quantity, std::vector<double>(values.begin(), values.end())};
}

void WriteRecords(const std::string& path, const StageRecords& records) {
  std::ofstream file(path, std::ios::binary);
  WriteCount(file, records.size());
  for (const StageRecord& record : records) {
    WriteText(file, record.stage);
    WriteText(file, record.quantity);
    WriteCount(file, record.values.size());
    file.write(reinterpret_cast<const char*>(record.values.data()),
               static_cast<std::streamsize>(record.values.size() * sizeof(double)));
  }
  file.flush();
  if (!file) throw std::runtime_error("cannot write " + path);
}

StageRecords ReadRecords(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  StageRecords records(ReadCount(file));
  for (StageRecord& record : records) {
    record.stage = ReadText(file);
    record.quantity = ReadText(file);
    record.values.resize(ReadCount(file));
    file.read(reinterpret_cast<char*>(record.values.data()),
              static_cast<std::streamsize>(record.values.size() * sizeof(double)));
  }
  if (!file) throw std::runtime_error(path + " is cut off");
  return records;
}

std::vector<StageDifference> Compare(const StageRecords& a, const StageRecords& b) {
  if (a.size() != b.size()) {
    throw std::invalid_argument("stages: " + std::to_string(a.size()) + " records in one file, " +
                                std::to_string(b.size()) + " in the other");
  }
  std::vector<StageDifference> differences;
  for (size_t i = 0; i < a.size(); ++i) differences.push_back(DifferenceOf(a[i], b[i]));
  return differences;
}

}  // namespace freelsd
