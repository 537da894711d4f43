// Input: the frontend's state of a flight. Output: which regions are evaluated together, on which
// ground and with which views; and which further fields of a finished map get a site.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engine/adjustment/adjustment.h"
#include "engine/approach/approach.h"
#include "engine/classification/classification.h"
#include "engine/flight/flight.h"
#include "engine/hazard/hazard.h"
#include "engine/regions/regions.h"
#include "engine/segmentation/segmentation.h"
#include "engine/stereo/stereo.h"
#include "engine/terrain/terrain.h"
#include "engine/tracks/tracks.h"
#include "engine/wind/wind.h"

namespace freelsd {

struct BackendOptions {
  // Every N frames the best n regions are evaluated. Paper: N = 150, n = 1.
  int backend_period_frames = 150;
  int num_backend_candidates = 1;
  // Ground mapped around the regions: enough for final and circle, at most this.
  double max_surroundings_m = 400.0;
  // Most key-frames in one evaluation. Regions that need more are evaluated in groups. A single
  // region uses those nearest to its middle.
  int max_num_views = 300;
  // Regions farther apart than this are evaluated in groups, each on its own map.
  double max_group_extent_m = 1500.0;
  // Most further fields within the rectangle of one region that get a site. Differs: the paper has
  // one site per region, but grass connects through gaps in hedges, so one rectangle may hold many
  // fields (decision 0006). Paper: 0.
  int max_num_further_fields = 12;
  // Connected ground is searched in pieces of this extent. Touchdowns of one region lie at least
  // half of it apart.
  double further_field_extent_m = 60.0;

  void Check() const;
};

struct PipelineOptions {
  TracksOptions tracks;
  SegmentationOptions segmentation;
  ClassificationOptions classification;
  RegionsOptions regions;
  WindOptions wind;
  AdjustmentOptions adjustment;
  StereoOptions stereo;
  TerrainOptions terrain;
  HazardOptions hazard;
  ApproachOptions approach;
  BackendOptions backend;

  void Check() const;
};

// A view's grass mask, run-length encoded: a flight stores one per frame.
struct PackedMask {
  // Consecutive pixels of one value, row after row.
  struct Run {
    uint8_t value = 0;
    uint32_t length = 0;
  };
  cv::Size size;
  std::vector<Run> runs;
  // As in GrassView.
  double image_px_per_mask_px = 1.0;

  cv::Mat1b Unpack() const;
};

// A region, and the wind at its centre.
struct Candidate {
  Region region;
  std::optional<WindEstimate> wind;
};

// The frontend's state that the backend needs. A copy, so that both can run at once.
struct Snapshot {
  Rig rig;
  std::vector<View> views;
  // Same order as views.
  std::vector<PackedMask> grass_masks;
  // Best first.
  std::vector<Candidate> regions;
  int min_num_observations = 2;
  std::vector<WindSample> wind_samples;
};

// An evaluated region.
struct Site {
  // For a further field, the rectangle around that field; else the tracked region.
  Region region;
  // 1 for the region's own site, 2 and up for further fields: a rectangle may hold several fields
  // that suit different winds.
  int field_number = 1;
  std::optional<WindEstimate> wind;
  Plan plan;
};

// Horizontal, world, metres. A new box is empty.
struct Box {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  void Add(const Eigen::Vector2d& point);
  void Grow(double margin);
  bool IsEmpty() const;
  double DistanceTo(const Eigen::Vector2d& point) const;
  Box Intersection(const Box& other) const;
};

// Ground that finals and circles around the regions may need: in calm, in the strongest wind of the
// regions and, if one region has no wind, with the tail wind of unknown_wind_mps.
Box AreaOfInterest(const std::vector<Candidate>& regions,
                   const Aircraft& aircraft,
                   const ApproachOptions& approach,
                   const BackendOptions& options);

// The key-frames that see an area.
struct Selection {
  std::vector<View> views;
  // Indices of `views` in the snapshot, ascending.
  std::vector<size_t> indices;
  // Number of views that see the area, before max_num_views drops the farthest.
  size_t num_seeing = 0;
};
Selection SelectViews(const Snapshot& snapshot,
                      const Box& area,
                      const AdjustmentOptions& adjustment,
                      const BackendOptions& options);

// Ground around the landmarks of an adjusted block.
Box SeenArea(const AdjustedBlock& block);

// Groups of regions that one map can hold, best first within each. A farm survey is one group; a
// cross-country flight has many.
std::vector<std::vector<Candidate>> GroupRegions(const Snapshot& snapshot,
                                                 const std::vector<Candidate>& regions,
                                                 const Aircraft& aircraft,
                                                 const PipelineOptions& options);

// As AdjustPoses. If the block falls apart into groups or drops views, the photographs are matched
// again on the ground and adjusted with the new matches. Returns the block whose largest group has
// the most views.
AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options);

// The fine mask of a view: 0 where no segment has a sure class, else the segment's probability.
cv::Mat1b GrassMask(const Segments& segments, const Labels& labels);

PackedMask Packed(const cv::Mat1b& mask, double image_px_per_mask_px);

// Masks of the adjusted views, with adjusted poses and camera. `indices`: the block's views in the
// snapshot.
std::vector<GrassView> AdjustedGrassViews(const Snapshot& snapshot,
                                          const std::vector<size_t>& indices,
                                          const AdjustedBlock& block);

// Ground within a region on which the touchdown disc fits, as regions with their own rectangle and
// the observations of the whole. Connected ground is cut into pieces of at most max_extent_m,
// because the map may not show a border in it. Widest first.
std::vector<Region> FurtherFields(const Region& region,
                                  const ElevationMap& map,
                                  const HazardLayers& hazards,
                                  double required_hazard_distance,
                                  double max_extent_m);

// The sites, one per region, followed by landable further fields of accepted sites, planned by
// `plan`. Skips fields near an existing site of any region.
std::vector<Site> WithFurtherSites(std::vector<Site> sites,
                                   const ElevationMap& map,
                                   const HazardLayers& hazards,
                                   const Aircraft& aircraft,
                                   const PipelineOptions& options,
                                   const std::function<Site(const Region& field)>& plan);

}  // namespace freelsd
