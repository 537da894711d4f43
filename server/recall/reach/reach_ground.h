// The ground of stored maps on one grid around an aircraft. Private to recall.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "engine/geometry/geometry.h"
#include "engine/glide/glide.h"
#include "server/recall/map_cache.h"
#include "server/recall/recall_sites.h"
#include "server/recall/site_lru.h"

namespace freelsd {

// East and north in metres from a fixed place nearby, on the ellipsoid. Aircraft close to each
// other share one frame, so that patches of ground can be kept.
class ReachFrame {
 public:
  explicit ReachFrame(const GeoPoint& place);

  const GeoPoint& anchor() const { return local_frame_.origin(); }
  Eigen::Vector2d FromGeo(const GeoPoint& place) const;
  // Longitude continuous with the place of the constructor: it may leave [-180, 180].
  GeoPoint ToGeo(const Eigen::Vector2d& place_in_frame) const;
  // Direction of true north at the place of the constructor, radians clockwise from the frame's.
  double north() const { return north_; }

 private:
  GeoPoint place_;
  LocalFrame local_frame_;
  double north_ = 0.0;
};

// A map's ground in cells of a fixed size; cell (0, 0) has its north-western corner at the anchor.
struct GroundPatch {
  // What it was made from.
  std::weak_ptr<const KeptTerrain> terrain;
  GeoPoint anchor;
  // x: columns to the east of the anchor, y: rows to the south.
  cv::Point north_west;
  // Altitude of the highest surface that is seen in each cell, in the map's datum; -infinity where
  // none is.
  cv::Mat1f top;
  // 255 where the whole cell is seen.
  cv::Mat1b is_known;
  double lowest = 0.0;
  double highest = 0.0;
};

// Side of a patch's cell.
constexpr double kPatchCellM = 2.0;

// Thread-safe.
class GroundPatches {
 public:
  explicit GroundPatches(size_t max_bytes) : patches_(max_bytes) {}

  // The map's patch, made from this terrain. Nothing if no cell of the map is seen.
  std::shared_ptr<const GroundPatch> PatchOf(const MapRow& row,
                                             const std::shared_ptr<const KeptTerrain>& terrain,
                                             const ReachFrame& frame);

 private:
  // Guards patches_.
  std::mutex mutex_;
  SiteLru<std::shared_ptr<const GroundPatch>> patches_;
};

// A patch, and what to add to its altitudes to compare them with the request's.
struct PlacedPatch {
  std::shared_ptr<const GroundPatch> patch;
  double added_m = 0.0;
};

struct NearbyGround {
  // In the frame. `top` holds altitudes in the request's datum.
  ReachGround ground;
  // Highest ground of the maps on the grid; the height that is assumed where none is known.
  double assumed_altitude_m = 0.0;
  size_t num_maps = 0;
};

// Grid of at most `max_num_cells` cells a side around the place. `patches` are not empty.
NearbyGround GroundAround(const Eigen::Vector2d& place_in_frame,
                          double half_size_m,
                          const std::vector<PlacedPatch>& patches);

}  // namespace freelsd
