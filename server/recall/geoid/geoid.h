// Height of the geoid, the surface of mean sea level, above the WGS84 ellipsoid.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace freelsd {

// Upper bound of the distance between geoid and ellipsoid anywhere on earth, metres.
constexpr double kMaxGeoidHeightM = 110.0;

// EGM96, read from PROJ's grid egm96_15.gtx. The grid has a node every 15 minutes of arc. Heights
// between the nodes are interpolated linearly. Cells are cached, because PROJ is too slow for
// thousands of sites. Thread-safe.
class Geoid {
 public:
  Geoid();
  ~Geoid();
  Geoid(const Geoid&) = delete;
  Geoid& operator=(const Geoid&) = delete;

  // Height in metres. Altitude above the ellipsoid = altitude above mean sea level + height.
  // Nothing if the grid is not installed.
  std::optional<double> HeightAt(double latitude_deg, double longitude_deg);

 private:
  // Heights at the corners: south-west, south-east, north-west, north-east.
  using Cell = std::array<double, 4>;
  class GridReader;
  // The caller holds mutex_.
  std::optional<Cell> CellAt(int row, int col);

  // Guards the members below, including the reader's PROJ context, which only one thread may use at
  // a time.
  std::mutex mutex_;
  // Nothing before the first call of HeightAt.
  std::unique_ptr<GridReader> grid_;
  std::unordered_map<int, Cell> cells_;
};

// The geoid of this process. All callers share it, because the grid never changes.
Geoid& Egm96();

}  // namespace freelsd
