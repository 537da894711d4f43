// Height of the geoid, the surface of mean sea level, above the WGS84 ellipsoid.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace freelsd {

// The largest height of the geoid anywhere, in metres, above or below the ellipsoid.
constexpr double kMaxGeoidHeightM = 110.0;

// EGM96 as PROJ's grid egm96_15.gtx has it: nodes every 15 minutes, linear between them. Thread-
// safe. It remembers the cells that were asked for, because PROJ is too slow for thousands of
// sites.
class Geoid {
 public:
  // Metres: altitude above the ellipsoid = altitude above mean sea level + height. Nothing if the
  // grid is not installed.
  std::optional<double> HeightAt(double latitude_deg, double longitude_deg);

 private:
  // Heights at the corners: south-west, south-east, north-west, north-east.
  using Cell = std::array<double, 4>;
  std::optional<Cell> CellAt(int row, int col);

  // Guards the members below.
  std::mutex mutex_;
  std::unordered_map<int, Cell> cells_;
  bool is_missing_ = false;
};

// One for the whole process: the grid is a constant of nature.
Geoid& Egm96();

}  // namespace freelsd
