// Maps of an evaluation on their way to storage. Private to work.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "api/stored/map/map.h"
#include "engine/pipeline.h"
#include "server/jobs/service.h"

namespace freelsd {

// WGS84 box around the grid; west > east if it crosses the antimeridian.
BoundingBox BoxOf(const Grid& grid, const LocalFrame& local_frame);

// When the newest of the block's photographs was taken, or of those that show a place.
CaptureTime SeenAt(const AdjustedBlock& block,
                   const CaptureTimes& times,
                   const std::optional<Eigen::Vector3d>& place_in_world = std::nullopt);
// As in a row that is written now. Empty if the time is exact.
std::optional<int64_t> SeenUntil(const CaptureTime& seen, int64_t now_us);

// Maps that an evaluation has stored but that do not count yet. The destructor removes those that
// were not taken.
class StagedMaps {
 public:
  StagedMaps(Service& service, const FlightContext& context)
      : service_(service), context_(context) {}
  ~StagedMaps();
  StagedMaps(const StagedMaps&) = delete;
  StagedMaps& operator=(const StagedMaps&) = delete;

  // What the map is made of.
  struct Source {
    // With the datum of all altitudes.
    const FlightRequest& flight;
    const GeoPoint& origin;
    const ImageSource& images;
    // SHA-256 of the grass model's file.
    const std::string& model_digest;
    const CaptureTimes& times;
  };
  // Stores the evaluation's map with its picture and returns its id; empty if nothing was
  // reconstructed. Throws std::runtime_error("cancelled") if `progress` returned false.
  std::string Add(const Evaluation& evaluation, const Source& source, const Progress& progress);
  // The same at once: the picture takes a while.
  std::string AddWithoutPicture(const Evaluation& evaluation, const Source& source);
  // SHA-256 of the tiles of a map, its picture left out; empty for an empty id.
  std::string DigestOf(const std::string& map_id) const;
  const std::vector<FlightMapRow>& rows() const { return rows_; }
  // Call it once the maps are in force.
  void Take() { rows_.clear(); }

 private:
  std::string AddMap(const Evaluation& evaluation, const Source& source, MapHead head);
  void AddPicture(const Evaluation& evaluation,
                  const std::string& map_id,
                  const ImageSource& images,
                  const Progress& progress);

  Service& service_;
  const FlightContext& context_;
  std::vector<FlightMapRow> rows_;
  // By map.
  std::map<std::string, std::string> digests_;
};

}  // namespace freelsd
