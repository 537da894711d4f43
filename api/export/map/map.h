// Input: parts ("windows") of a flight's map, and of its picture from above. Output: web map tiles,
// TileJSON, pictures of a box, GeoTIFF, KMZ, legends.
//
// Windows lie in world: the local east-north frame of the flight, metres. Row 0 is the northern
// edge, column 0 the western. The cells of level l are 2^l times as large as the finest cells, and
// their edges are at multiples of their size from the world origin. Windows may overlap. The first
// window that has seen a place shows it.
//
// A picture never shows a place as safer than the windows do: a pixel of hazard and distance is
// free only if every cell that it touches is free, and a pixel of risk shows the largest risk of
// these cells. All functions are pure, except that the GeoTIFF functions write a file.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>

#include "api/export/layers/layers.h"
#include "api/stored/map/map.h"
#include "api/stored/stored.h"

namespace freelsd {

// --- Windows ---

// Every raster has the size of the grid or is empty. `elevation` and `hazard` are never empty.
using MapWindow = MapRasters;

// The ground from straight above.
struct PhotoWindow {
  // One cell per pixel.
  Grid grid;
  // BGRA, not premultiplied. Alpha is 0 where unseen.
  cv::Mat4b pixels;
};

// A box in world, metres.
struct WorldBox {
  Eigen::Vector2d min_in_world = Eigen::Vector2d::Zero();
  Eigen::Vector2d max_in_world = Eigen::Vector2d::Zero();
};

// The next level: cells of twice the size, each made of four cells. Cells outside the window count
// as unseen. `hazard` is kHazard if one of the four is, else kUnseen if one is, else kFree: no
// choice of windows makes a coarse cell free if one of its cells is not. `elevation` is the mean of
// its known cells, `upper` their largest. Of the other rasters the least favourable value is taken
// (least: grass, distance, num_points, coverage; largest: standard_deviation, slope, roughness);
// NaN if one is NaN. Coarse windows are for pictures and for the terrain on a way, not for
// landings. Throws std::invalid_argument if the grid is not aligned to its cell size.
MapWindow Coarser(const MapWindow& window);
// Mean colour of the seen pixels; the largest alpha.
PhotoWindow Coarser(const PhotoWindow& window);

// Fills the window's `risk`: the probability that the ground of a cell is not fit to land on, by
// its kind and by its shape (engine/risk); NaN where unseen. It does not tell whether a landing
// there would have room, or a way to it. In coarse cells, the height that the slope explains is no
// object, so a low object on a slope counts less there than in the finest cells.
void AddRisk(MapWindow& window, const Aircraft& aircraft, double finest_cell_size_m);

// --- Layers ---

// "photo", "hazard", "elevation", "slope", "roughness", "grass", "distance", "height_sd",
// "coverage", "risk", "kind". Functions that take the name of a layer throw std::invalid_argument
// if no such layer exists. Only functions with Photo in their name, MapJson and the KMZ take
// "photo".
std::vector<std::string> MapLayerNames();

// Values at the two ends of the layer's ramp, or nothing if no cell of the window is seen.
// Elevation is an altitude, and 1 % of its cells is beyond each end, so that a few trees do not
// hide the relief. For the others, but coverage and distance, the values are fixed.
std::optional<Scale> MapScale(const std::string& layer,
                              const MapWindow& window,
                              const LocalFrame& local_frame);
Scale RiskScale();
// The scale that contains both.
Scale MergedScale(const Scale& a, const Scale& b);
// PNG with the layer's colours, values and unit.
std::string MapLegendPng(const std::string& layer, const Scale& scale);

// --- Web map tiles ---

// A tile of the Web Mercator pyramid (EPSG:3857, XYZ). Row 0 is the northern edge.
struct XyzTile {
  int z = 0;
  int x = 0;
  int y = 0;

  // Throws std::invalid_argument if the tile does not exist. z is 0 to 30.
  void Check() const;
};
constexpr int kTileSizePx = 256;

// WGS84.
struct GeoBounds {
  double west_deg = 0.0;
  double south_deg = 0.0;
  double east_deg = 0.0;
  double north_deg = 0.0;
};
GeoBounds BoundsOf(const XyzTile& tile);
// The tile that contains a place.
XyzTile TileAt(const GeoPoint& place, int zoom);
// The world box that windows for the tile should cover, margin included. Nothing if the tile is
// more than 100 km from the flight's origin.
std::optional<WorldBox> WorldBoxOf(const XyzTile& tile, const LocalFrame& local_frame);
// The coarsest of the levels 0 to num_levels - 1 whose cells are not larger than the tile's pixels;
// 0 if there is none.
int LevelOf(const XyzTile& tile,
            const LocalFrame& local_frame,
            double finest_cell_size_m,
            int num_levels);

// PNG of 256 x 256 pixels, transparent outside the windows. Unseen ground is transparent, but in
// hazard, distance and risk it has an opaque colour of its own. `scale` must be the same for all
// tiles of a flight.
std::string MapTilePng(const std::string& layer,
                       const XyzTile& tile,
                       const std::vector<MapWindow>& windows,
                       const Scale& scale,
                       const LocalFrame& local_frame);
std::string PhotoTilePng(const XyzTile& tile,
                         const std::vector<PhotoWindow>& windows,
                         const LocalFrame& local_frame);
// White where nothing is seen.
std::string PhotoTileJpeg(const XyzTile& tile,
                          const std::vector<PhotoWindow>& windows,
                          const LocalFrame& local_frame);

// --- Pictures of a box ---
// North is up and rows are lines of equal north in world, so these pictures fit into drawings in
// world. A whole number of pixels of about the given size fills the box. They throw
// std::invalid_argument for an empty box.

// White where nothing is seen.
std::string PhotoBoxJpeg(const WorldBox& box,
                         double pixel_size_m,
                         const std::vector<PhotoWindow>& windows,
                         const LocalFrame& local_frame);

// What is seen through the picture of the hazard.
enum class Backdrop { kNone, kPhoto };
// PNG, transparent outside the windows. Unseen ground is hatched: it differs from hazard without
// colour too.
std::string HazardBoxPng(const WorldBox& box,
                         double pixel_size_m,
                         const std::vector<MapWindow>& windows,
                         Backdrop backdrop,
                         const LocalFrame& local_frame);
// PNG with the colours of the scale: slope, roughness, grass, height_sd or coverage. Transparent
// where nothing is seen.
std::string LayerBoxPng(const std::string& layer,
                        const WorldBox& box,
                        double pixel_size_m,
                        const std::vector<MapWindow>& windows,
                        const Scale& scale,
                        const LocalFrame& local_frame);

// --- The list of layers ---

struct MapDescription {
  // Absolute address of the flight's map, without a slash at its end: https://host/v1/flights/7/map
  std::string base_url;
  WorldBox extent;
  double cell_size_m = 1.0;
  // Nothing if the flight has no photo.
  std::optional<double> photo_pixel_size_m;
  // The layers' scales. A layer without scale is left out, except photo.
  std::vector<std::pair<std::string, Scale>> scales;
  std::optional<std::string> attribution;
  // RFC 3339.
  std::string updated_at;
};
// {layers: [TileJSON 3.0 with unit, min, max, legend, geotiff, kmz?], updated_at}. `min` and `max`
// are the ends of the scale, null for photo.
nlohmann::json MapJson(const MapDescription& map, const LocalFrame& local_frame);

// --- Files of the whole map ---

// Gives the windows of a level that intersect a box.
using MapWindowsOf = std::function<std::vector<MapWindow>(const WorldBox& box, int level)>;
using PhotoWindowsOf = std::function<std::vector<PhotoWindow>(const WorldBox& box, int level)>;

struct MapSource {
  WorldBox extent;
  double finest_cell_size_m = 1.0;
  // The windows have the levels 0 to num_levels - 1.
  int num_levels = 1;
  MapWindowsOf windows_of;
  // Boxes that together hold all windows. If there are none, the extent holds them.
  std::vector<WorldBox> parts;
};
struct PhotoSource {
  WorldBox extent;
  double finest_pixel_size_m = 0.1;
  int num_levels = 1;
  PhotoWindowsOf windows_of;
  std::vector<WorldBox> parts;
};

struct GeoTiffOptions {
  // Pixels of full size in tiles that meet a part. A core draws and packs five million of them in a
  // second: a quarter of an hour.
  double max_num_pixels = 4e9;
  // Tiles of full size, also those that are left out: the index of the file, which is held in
  // memory, has 16 bytes for each.
  double max_num_tiles = 4e6;
};

// Tiled GeoTIFF with an overview per level, in the UTM zone of the flight's origin (WGS84; UPS near
// the poles). Its rows are lines of equal northing: programs that ignore a rotation in the file, of
// which there are many, would else shift a hazard by up to 50 m per km (meridian convergence).
// Pixels have the size of the cells. float32, NaN unseen and outside; elevation is an altitude;
// `hazard` is 0 free, 1 hazard, 2 unseen; `grass` is 1 at or above the window's
// min_grass_posterior, else 0. An overview is made of the windows of its level. Tiles that meet no
// part of the source are left out of the file ("sparse"): GDAL reads them as NaN, or as
// transparent. Uses memory for some tiles and the index only. Throws ApiError TooLarge by the
// options, and std::runtime_error if the file cannot be written.
void WriteLayerGeoTiff(const std::string& path,
                       const std::string& layer,
                       const MapSource& source,
                       const LocalFrame& local_frame,
                       const GeoTiffOptions& options = {});
// RGBA, alpha not premultiplied.
void WritePhotoGeoTiff(const std::string& path,
                       const PhotoSource& source,
                       const LocalFrame& local_frame,
                       const GeoTiffOptions& options = {});

// A part of a photograph, BGR; black beyond it.
std::string PatchPng(const cv::Mat& image, const cv::Rect& wanted);

// KMZ with one GroundOverlay, north up, of at most 2048 x 2048 pixels. `name` is shown to people.
// `layer` is any layer but photo; its picture has the colours of `scale`.
std::string MapKmz(const std::string& name,
                   const std::string& layer,
                   const MapSource& source,
                   const Scale& scale,
                   const LocalFrame& local_frame);
std::string PhotoKmz(const std::string& name,
                     const PhotoSource& source,
                     const LocalFrame& local_frame);

}  // namespace freelsd
