// Private to map/. Pictures and values of layers at the pixels of a tile, a GeoTIFF or a KMZ.
#pragma once

#include <array>

#include "api/export/map/map_layer.h"
#include "api/export/map/pixel_places.h"

namespace freelsd {

// One value per pixel of a box.
struct Safety {
  // Outside of all windows.
  static constexpr uint8_t kOutside = 255;
  // The worst Hazard of all cells that the pixel touches: kHazard, else kUnseen, else kFree.
  // Outside counts as unseen, unless the whole pixel is outside.
  cv::Mat1b state;
  // Least distance to a hazard of these cells, metres, or their largest risk. Only meaningful where
  // the state is kFree. Empty for the layer hazard.
  cv::Mat1f value;
};
// `layer`: one of hazard, distance and risk.
Safety SafetyOf(const PixelPlaces& places, const std::vector<MapWindow>& windows, MapLayer layer);
bool IsSafetyLayer(MapLayer layer);

// Colours of the indices of IndicesOf, BGRA.
using Palette = std::array<cv::Vec4b, 256>;
Palette PaletteOf(const std::string& layer);
// Index into the palette of each pixel of the box, for every layer but photo and elevation. The
// pixels of hazard, distance and risk are those of Safety, others show the cell at their centre.
cv::Mat1b IndicesOf(MapLayer layer,
                    const PixelPlaces& places,
                    const std::vector<MapWindow>& windows,
                    const Scale& scale);
// Shaded elevation, BGRA. The scale is in altitudes.
cv::Mat4b ElevationPicture(const PixelPlaces& places,
                           const std::vector<MapWindow>& windows,
                           const Scale& scale,
                           const LocalFrame& local_frame);
// Values as in the GeoTIFF.
cv::Mat1f ValuesOf(MapLayer layer,
                   const PixelPlaces& places,
                   const std::vector<MapWindow>& windows,
                   const LocalFrame& local_frame);

// The picture from above, BGRA. If a pixel is larger than those of the windows, it has the mean
// colour of several of them.
cv::Mat4b PhotoPicture(const PixelPlaces& places, const std::vector<PhotoWindow>& windows);

}  // namespace freelsd
