// The stored form of a flight's map: a head as JSON, and square tiles of the flight's grid as
// blobs. The flight's grid is a lattice of cells through the world's origin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "api/stored/stored.h"

namespace freelsd {

// Cells on each side of a tile.
constexpr int kTileCells = 128;

// A tile. The cells of level l are 2^l cells of the map wide. Tile (0, 0) of each level has its
// north-western corner at the world's origin. Rows count to the south, columns to the east.
struct MapTileIndex {
  int level = 0;
  int row = 0;
  int col = 0;

  bool operator==(const MapTileIndex&) const = default;
  bool operator<(const MapTileIndex& other) const {
    return std::tie(level, row, col) < std::tie(other.level, other.row, other.col);
  }
};
Grid GridOf(const MapTileIndex& index, double cell_size_m);
// Tiles of a level that the grid touches: first and last, inclusive. The grid is of level 0 and
// aligned to multiples of its cell size. Not for an empty grid.
std::pair<MapTileIndex, MapTileIndex> TilesUnder(const Grid& grid, int level);

// A part of a flight's map in memory. All rasters have one size.
struct MapRasters {
  SiteMap site_map;
  // Number of photographs that see the cell, at most 255. Empty if it was not computed.
  cv::Mat1b coverage;
  // What told grass from other ground. Of the finest level only; may be empty.
  std::vector<CueLayer> cues = {};
  // As AddRisk (api/export/map) computes it. Never stored; empty if it was not computed.
  cv::Mat1f risk = {};
};
// All cells of the grid unseen.
MapRasters UnseenRasters(const Grid& grid);
// Copies the cells of `from` that lie on the grid of `to`. Both grids have the same lattice.
void CopyCells(const MapRasters& from, MapRasters& to);

enum class TileLayers {
  kPlanning,  // what WithLimits needs; hazard is kUnseen, distance 0 and coverage empty
  kAll,       // without cues
  kWithCues,
};

// Values are rounded to MapSteps, so a map of AssessHazards comes back bit for bit. Exceptions:
// distance is rounded down to 1/16 m, and the values of HazardLayers that are no rasters are not
// part of a tile. Returns nothing if no cell is seen.
std::string SerializeTile(const MapRasters& tile);
// Throws DamagedMap on damage and std::runtime_error on another version.
MapRasters DeserializeTile(const std::string& bytes, const Grid& grid, TileLayers layers);

// A tile of the picture, BGRA. JPEG, so the colours come back nearly, alpha exactly.
// DeserializePhotoTile throws DamagedMap on damage that it can see.
std::string SerializePhotoTile(const cv::Mat4b& picture);
cv::Mat4b DeserializePhotoTile(const std::string& bytes);

// A photograph of the map, as it was adjusted.
struct MapView {
  std::string frame_id;
  Rigid3d world_from_camera;
  Readout readout;
  double height_above_ground = 0.0;
  // Views of the map that stereo matched it with, as indices. Once for each pair.
  std::vector<size_t> partners = {};
};

// Range of a layer's values over the whole map.
struct LayerRange {
  std::string name;
  double min = 0.0;
  double max = 0.0;
};

// How well the photographs of the map fit together.
struct BlockQuality {
  double rms_before_px = 0.0;
  double rms_after_px = 0.0;
  int num_views = 0;
  int num_connected_views = 0;
  int num_landmarks = 0;
  // Why the block, or a group of its views, is not usable. Often empty.
  std::string note;
};

// Where the tiles of the map's picture lie, as in MosaicLattice.
struct PhotoLattice {
  double pixel_size_m = 0.1;
  int tile_size_px = 512;
  int num_levels = 1;

  // Tile (row, col) of a level. Rows count to the south from the world's origin.
  Grid GridOf(const MapTileIndex& index) const;
};

// One map of a flight, without its tiles. A long flight has several maps.
struct MapHead {
  // FlightRequest::canonical_json, with the datum of all altitudes.
  std::string flight_json;
  GeoPoint origin;
  // Of level 0.
  Grid grid;
  int num_levels = 1;
  double position_sd_m = 0.0;
  double tilt_sd_deg = 0.0;
  bool is_compared = false;
  // At the middle of the map, at the time of the evaluation.
  std::optional<WindEstimate> wind;
  Camera camera;
  // Connected views only.
  std::vector<MapView> views;
  std::vector<LayerRange> ranges;
  // Nothing if the map has no picture.
  std::optional<PhotoLattice> photo;
  BlockQuality quality;
  // Version of the program that made the map, and SHA-256 of its grass model's file.
  std::string program_version = {};
  std::string model_sha256 = {};
};
std::string MapHeadJson(const MapHead& head);
// Throws std::exception on text that MapHeadJson did not write.
MapHead ParseMapHead(const std::string& text);

}  // namespace freelsd
