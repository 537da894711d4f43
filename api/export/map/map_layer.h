// Private to map/. The layers of a flight's map and their values.
#pragma once

#include "api/export/map/map.h"

namespace freelsd {

enum class MapLayer {
  kPhoto,
  kHazard,
  kElevation,
  kSlope,
  kRoughness,
  kGrass,
  kDistance,
  kHeightSd,
  kCoverage,
  kRisk,
  kKind,
};

// Throws std::invalid_argument if no layer has the name.
MapLayer MapLayerOf(const std::string& name);
// The same for a layer of MapWindow: not the photo.
MapLayer ValueLayerOf(const std::string& name);
std::string UnitOf(MapLayer layer);

// Throws std::invalid_argument unless the rasters have the sizes that MapWindow states.
void CheckWindow(const MapWindow& window);
void CheckWindow(const PhotoWindow& window);

// Throws std::invalid_argument unless the scale is finite and ascending.
void CheckScale(const Scale& scale);

// A raster of a window, and how to compute the layer's values from its values. Empty if the window
// does not have it.
struct LayerRaster {
  const cv::Mat1f* values = nullptr;
  // Only for coverage.
  const cv::Mat1b* counts = nullptr;
  // Only for the kind of ground.
  const cv::Mat1b* kinds = nullptr;
  float factor = 1.0f;

  bool IsEmpty() const;
  // Value in the unit of the layer; NaN where unseen. Elevation is world z, grass the posterior,
  // kind a GroundKind.
  float At(int row, int col) const;
};
// Throws std::invalid_argument for the photo and hazard, which are drawn by other rules.
LayerRaster RasterOf(const MapWindow& window, MapLayer layer);

// Cell of one of the windows.
struct WindowCell {
  // Nothing if the place is outside of all windows.
  const MapWindow* window = nullptr;
  int index = 0;  // of the window
  int row = 0;
  int col = 0;
};

// Finds the cell that shows a place: that of the first window in which hazard is seen, else the
// first in which the elevation is known, else the first that a photograph sees, else the first.
class CellFinder {
 public:
  explicit CellFinder(const std::vector<MapWindow>& windows);
  WindowCell At(const Eigen::Vector2d& place_in_world) const;

 private:
  struct Placed {
    const MapWindow* window;
    double west, north, cells_per_m;
    int num_rows, num_cols;
  };
  std::vector<Placed> windows_;
};

}  // namespace freelsd
