// Rejects invalid values with an error that names the field; every Check() uses it.
#pragma once

#include <string>

namespace freelsd {

// Checks the fields of one struct.
class FieldCheck {
 public:
  // `owner` begins each message: "approach", "aircraft".
  explicit FieldCheck(std::string owner);

  // Throws std::invalid_argument: "approach.calm_wind_mps = -1: must be in [0, 10]". A value that
  // is not finite counts as outside.
  void Inside(const char* field, double value, double min, double max) const;
  // For constraints other than a closed interval: "stereo.block_size_px = 4: must be odd".
  void Require(bool holds, const char* field, double value, const std::string& constraint) const;

 private:
  std::string owner_;
};

}  // namespace freelsd
