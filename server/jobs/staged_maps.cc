#include "server/jobs/staged_maps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/spdlog.h>

#include "api/export/layers/layers.h"
#include "engine/mosaic/mosaic.h"
#include "server/http/http.h"
#include "server/maps/maps.h"

namespace freelsd {
namespace {

BlockQuality QualityOf(const AdjustedBlock& block) {
  BlockQuality quality;
  quality.rms_before_px = block.rms_before_px;
  quality.rms_after_px = block.rms_after_px;
  quality.num_views = static_cast<int>(block.views.size());
  quality.num_landmarks = static_cast<int>(block.landmarks.size());
  quality.note = block.note;
  for (const AdjustedView& view : block.views) quality.num_connected_views += view.is_connected;
  return quality;
}

// Median of the connected views; 0 if there is none.
double GroundSamplingOf(const AdjustedBlock& block) {
  std::vector<double> samplings_m;
  for (const AdjustedView& view : block.views) {
    if (view.is_connected) {
      samplings_m.push_back(view.height_above_ground / block.camera.MeanFocalPx());
    }
  }
  if (samplings_m.empty()) return 0.0;
  const auto middle = samplings_m.begin() + static_cast<std::ptrdiff_t>(samplings_m.size() / 2);
  std::nth_element(samplings_m.begin(), middle, samplings_m.end());
  return *middle;
}

// Picking views for smaller cells takes more memory than the picture gains.
MosaicOptions OptionsOf(const AdjustedBlock& block) {
  constexpr double kPixelsPerSeamCell = 8.0;
  MosaicOptions options;
  options.max_cache_mb = 120.0;
  options.seam_cell_size_m =
      std::max(options.seam_cell_size_m, kPixelsPerSeamCell * GroundSamplingOf(block));
  return options;
}

// Connected views alone, with the pairs that stereo matched.
std::vector<MapView> ViewsOf(const AdjustedBlock& block, const StereoOptions& options) {
  std::vector<MapView> views;
  std::vector<size_t> places(block.views.size(), 0);
  for (size_t i = 0; i < block.views.size(); ++i) {
    const AdjustedView& view = block.views[i];
    if (!view.is_connected) continue;
    places[i] = views.size();
    views.push_back(
        {view.frame_id, view.world_from_camera, view.readout, view.height_above_ground});
  }
  for (const StereoPair& pair : SelectPairs(block, options)) {
    views[places[pair.left]].partners.push_back(places[pair.right]);
  }
  return views;
}

bool Shows(const AdjustedBlock& block,
           const AdjustedView& view,
           const Eigen::Vector3d& place_in_world) {
  const auto pixel = block.camera.ImageFromCamera(Inverse(view.world_from_camera) * place_in_world);
  return view.is_connected && pixel && block.camera.IsInside(*pixel);
}

MapHead HeadOf(const Evaluation& evaluation, const StagedMaps::Source& source) {
  const ElevationMap& map = evaluation.map;
  MapHead head;
  head.flight_json = source.flight.canonical_json;
  head.origin = source.origin;
  head.program_version = FREELSD_VERSION;
  head.model_sha256 = source.model_digest;
  head.grid = map.grid;
  head.position_sd_m = map.position_sd_m;
  head.tilt_sd_deg = map.tilt_sd_deg;
  head.is_compared = map.is_compared;
  head.wind = evaluation.wind;
  head.camera = evaluation.block.camera;
  head.views = ViewsOf(evaluation.block, source.flight.options.stereo);
  const MosaicLattice lattice = PlanMosaic(map, evaluation.block, OptionsOf(evaluation.block));
  if (lattice.num_levels > 0) {
    head.photo = PhotoLattice{lattice.pixel_size_m, lattice.tile_size_px, lattice.num_levels};
  }
  head.quality = QualityOf(evaluation.block);
  return head;
}

}  // namespace

BoundingBox BoxOf(const Grid& grid, const LocalFrame& local_frame) {
  constexpr double kPolarDeg = 89.9;
  const double origin_deg = local_frame.origin().longitude_deg;
  BoundingBox box{origin_deg + 360.0, 90.0, origin_deg - 360.0, -90.0};
  for (const Eigen::Vector2d& corner : OuterCorners(grid)) {
    GeoPoint place = local_frame.GeoFromWorld({corner.x(), corner.y(), 0.0});
    // Near the origin's longitude, so that a box across the antimeridian is in one piece.
    place.longitude_deg -= 360.0 * std::round((place.longitude_deg - origin_deg) / 360.0);
    box.west_deg = std::min(box.west_deg, place.longitude_deg);
    box.east_deg = std::max(box.east_deg, place.longitude_deg);
    box.south_deg = std::min(box.south_deg, place.latitude_deg);
    box.north_deg = std::max(box.north_deg, place.latitude_deg);
  }
  // The corners of a map at a pole do not bound its longitudes, nor its latitudes.
  if (box.north_deg > kPolarDeg) return {-180.0, box.south_deg, 180.0, 90.0};
  if (box.south_deg < -kPolarDeg) return {-180.0, -90.0, 180.0, box.north_deg};
  box.west_deg = std::remainder(box.west_deg, 360.0);
  box.east_deg = std::remainder(box.east_deg, 360.0);
  return box;
}

CaptureTime SeenAt(const AdjustedBlock& block,
                   const CaptureTimes& times,
                   const std::optional<Eigen::Vector3d>& place_in_world) {
  std::optional<CaptureTime> newest;
  for (const AdjustedView& view : block.views) {
    const auto time = times.find(view.frame_id);
    if (time == times.end() || (place_in_world && !Shows(block, view, *place_in_world))) continue;
    newest = newest ? Newest(*newest, time->second) : time->second;
  }
  if (newest) return *newest;
  return place_in_world ? SeenAt(block, times) : CaptureTime();
}

std::optional<int64_t> SeenUntil(const CaptureTime& seen, int64_t now_us) {
  return seen.IsExact() ? std::nullopt : std::optional(std::min(seen.latest_us, now_us));
}

StagedMaps::~StagedMaps() {
  for (const FlightMapRow& row : rows_) {
    try {
      service_.storage.maps.Discard(row.id);
    } catch (const StorageError& error) {
      // The next start removes it.
      spdlog::warn("map {} is not removed yet: {}", row.id, error.what());
    }
  }
}

std::string StagedMaps::DigestOf(const std::string& map_id) const {
  const auto found = digests_.find(map_id);
  return found == digests_.end() ? std::string() : found->second;
}

std::string StagedMaps::AddMap(const Evaluation& evaluation, const Source& source, MapHead head) {
  FlightMapRow row;
  row.id = service_.storage.maps.NewId(context_.flight_id);
  row.flight_id = context_.flight_id;
  row.altitude_datum = context_.altitude_datum;
  row.box = BoxOf(evaluation.map.grid, context_.local_frame);
  row.updated_at_us = NowUs();
  const CaptureTime seen = SeenAt(evaluation.block, source.times);
  row.seen_at_us = seen.earliest_us;
  row.seen_until_us = SeenUntil(seen, row.updated_at_us);
  rows_.push_back(row);
  digests_[row.id] = StageMap(service_.storage,
                              row,
                              std::move(head),
                              {.site_map = {evaluation.map, evaluation.hazards},
                               .coverage = evaluation.num_views,
                               .cues = evaluation.cues});
  return row.id;
}

std::string StagedMaps::Add(const Evaluation& evaluation,
                            const Source& source,
                            const Progress& progress) {
  if (evaluation.map.grid.num_rows == 0) return {};
  std::string map_id = AddMap(evaluation, source, HeadOf(evaluation, source));
  AddPicture(evaluation, map_id, source.images, progress);
  return map_id;
}

std::string StagedMaps::AddWithoutPicture(const Evaluation& evaluation, const Source& source) {
  if (evaluation.map.grid.num_rows == 0) return {};
  MapHead head = HeadOf(evaluation, source);
  head.photo.reset();
  return AddMap(evaluation, source, std::move(head));
}

void StagedMaps::AddPicture(const Evaluation& evaluation,
                            const std::string& map_id,
                            const ImageSource& images,
                            const Progress& progress) {
  const MosaicLattice lattice =
      PlanMosaic(evaluation.map, evaluation.block, OptionsOf(evaluation.block));
  const double num_tiles = std::max(1, lattice.tiles.area());
  StagedPicture picture(service_.storage, map_id);
  double num_kept = 0.0;
  MakeMosaic(evaluation.map,
             evaluation.block,
             images,
             OptionsOf(evaluation.block),
             [&](const MosaicTile& tile) {
               if (progress && !progress(std::min(1.0, num_kept / num_tiles), "picture")) {
                 throw std::runtime_error("cancelled");
               }
               num_kept += tile.level == 0 ? 1.0 : 0.0;
               picture.Add({tile.level, tile.row, tile.col}, SerializePhotoTile(tile.image));
             });
  picture.Finish();
}

}  // namespace freelsd
