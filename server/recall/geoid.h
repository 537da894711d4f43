// Height of the geoid, the surface of mean sea level, above the WGS84 ellipsoid.
#pragma once

#include <array>
#include <memory>
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
  Geoid();
  ~Geoid();
  Geoid(const Geoid&) = delete;
  Geoid& operator=(const Geoid&) = delete;

  // Metres: altitude above the ellipsoid = altitude above mean sea level + height. Nothing if the
  // grid is not installed.
  std::optional<double> HeightAt(double latitude_deg, double longitude_deg);

 private:
  // Heights at the corners: south-west, south-east, north-west, north-east.
  using Cell = std::array<double, 4>;
  class GridReader;
  // The caller holds mutex_.
  std::optional<Cell> CellAt(int row, int col);

  // Guards the members below. PROJ forbids two threads in one context at once; the reader's is only
  // used by the thread that holds this.
  std::mutex mutex_;
  // Nothing before the first question.
  std::unique_ptr<GridReader> grid_;
  std::unordered_map<int, Cell> cells_;
};

// One for the whole process: the grid is a constant of nature.
Geoid& Egm96();

}  // namespace freelsd
