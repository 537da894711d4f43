// Refuses given numbers by name: what every Check() is made of.
#pragma once

#include <string>

namespace freelsd {

// The fields of one struct.
class FieldCheck {
 public:
  // `owner` begins each message: "approach", "aircraft".
  explicit FieldCheck(std::string owner);

  // Throws std::invalid_argument: "approach.calm_wind_mps = -1: must be in [0, 10]". What is not
  // finite lies outside.
  void Inside(const char* field, double value, double min, double max) const;
  // The same of what no closed interval says: "stereo.block_size_px = 4: must be odd".
  void Require(bool holds, const char* field, double value, const std::string& constraint) const;

 private:
  std::string owner_;
};

}  // namespace freelsd
