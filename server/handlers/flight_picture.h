// What is drawn of a flight's maps: all maps of the flight together, the newest on top, with the
// obstacles that are in force in the layers of hazard.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/export/map/map.h"
#include "server/jobs/jobs.h"
#include "server/maps/maps.h"

namespace freelsd {

// Maps of a flight that can be read, newest first. They share the flight's world and lattice. The
// head of a map whose picture was removed to free disk space has no photo.
std::vector<std::shared_ptr<const FlightMap>> ReadableMaps(const Service& service,
                                                           const std::string& flight_id);

class FlightPicture {
 public:
  // Throws ApiError NoSuchFlight, or NoMap if the flight has no map. The maps of a deleted flight
  // are still there. Calls `stop_if_unwanted` before each part that it reads.
  FlightPicture(
      const Service& service, const std::string& flight_id, StopIfUnwanted stop_if_unwanted = [] {
      });

  // Differs whenever the maps, their pictures or the obstacles on them differ.
  const std::string& version() const { return version_; }
  nlohmann::json Json(const std::string& base_url) const;
  // Throws ApiError NoMap where the layer is missing.
  void RequireLayer(const std::string& layer) const;
  // "image/png" or, for photo, "image/jpeg". Throws ApiError NoMap where the layer is missing.
  std::string Tile(const std::string& layer,
                   const XyzTile& tile,
                   const std::string& content_type) const;
  // Throws ApiError TooLarge.
  void WriteGeoTiff(const std::string& layer, const std::filesystem::path& file) const;
  std::string Kmz(const std::string& layer) const;
  std::string Legend(const std::string& layer) const;

  // Pictures of a box in world, with about `longest_px` pixels along its longer side.
  // JPEG; at most so many pixels. Empty if no photograph shows the box.
  std::string PhotoOf(const WorldBox& box, int longest_px) const;
  std::string HazardOf(const WorldBox& box, int longest_px, Backdrop backdrop) const;
  // Empty where the layer is missing.
  std::string LayerOf(const std::string& layer, const WorldBox& box, int longest_px) const;

  // Newest first.
  const std::vector<std::shared_ptr<const FlightMap>>& maps() const { return maps_; }
  const LocalFrame& Frame() const { return maps_.front()->local_frame; }

 private:
  int NumLevels() const;
  WorldBox Extent() const;
  std::optional<Scale> ScaleOf(const std::string& layer) const;
  Scale NeededScale(const std::string& layer) const;
  std::vector<MapWindow> Windows(const std::string& layer, const WorldBox& box, int level) const;
  // Those of the coarsest level whose cells are not larger than the pixels.
  std::vector<MapWindow> WindowsFor(const std::string& layer,
                                    const WorldBox& box,
                                    double pixel_size_m) const;
  MapSource Source(const std::string& layer) const;
  // Of the finest picture; nothing if no map has one.
  std::optional<double> PhotoPixelSize() const;
  // The same; throws ApiError NoMap.
  double NeededPixelSize() const;
  std::vector<PhotoWindow> PhotoWindows(const WorldBox& box, double pixel_size_m) const;
  PhotoSource SourceOfPhoto() const;
  // Boxes that together hold all photo tiles.
  std::vector<WorldBox> PhotoParts() const;
  std::string PhotoTile(const XyzTile& tile, const std::string& content_type) const;

  const Service& service_;
  std::string flight_id_;
  StopIfUnwanted stop_if_unwanted_;
  std::vector<std::shared_ptr<const FlightMap>> maps_;
  // In force now, in the maps' world.
  std::vector<HardObstacle> obstacles_;
  int64_t updated_at_us_ = 0;
  std::string version_;
};

}  // namespace freelsd
