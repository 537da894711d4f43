// Input: the frontend's state of a flight. Output: groups of regions that are evaluated together,
// with the ground and the views of each group. For a finished map: the sites anywhere on it.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engine/adjustment/adjustment.h"
#include "engine/approach/approach.h"
#include "engine/flight/flight.h"
#include "engine/ground_kind/ground_kind.h"
#include "engine/hazard/hazard.h"
#include "engine/obstacles/obstacles.h"
#include "engine/regions/regions.h"
#include "engine/segmentation/segmentation.h"
#include "engine/stereo/stereo.h"
#include "engine/terrain/terrain.h"
#include "engine/tracks/tracks.h"
#include "engine/wind/wind.h"

namespace freelsd {

struct BackendOptions {
  // The best num_backend_candidates regions are evaluated every backend_period_frames frames.
  // Paper: N = 150, n = 1.
  int backend_period_frames = 150;
  int num_backend_candidates = 1;
  // If a flight needs several maps, each shows the ground up to this distance from its regions. It
  // does not depend on the aircraft: any aircraft can be planned on the map later.
  double max_surroundings_m = 400.0;
  // Largest number of key-frames in one evaluation. Regions that need more are split into groups. A
  // single region that needs more uses the key-frames nearest to its middle.
  int max_num_views = 600;
  // Largest extent of the regions in one evaluation. Regions farther apart are split into groups,
  // each with its own map.
  double max_group_extent_m = 1500.0;
  // Largest number of sites of one map, besides those of the regions. Differs: the paper has one
  // site per region. Grass connects through gaps in hedges, so one region may contain many fields
  // (decision 0006), and what the tracking lost may be on the map. Paper: 0.
  int max_num_map_sites = 40;
  // Side of the squares into which connected ground is cut. Each piece gets at most one site.
  double map_site_extent_m = 60.0;

  void Check() const;
};

// What the options started from. It decides which classifier belongs to them.
enum class Preset { kNone, kPaper };

struct PipelineOptions {
  Preset preset = Preset::kNone;
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

// Every stage in its published form, to be compared with (paper_options.cc).
PipelineOptions PaperOptions();
// The same for the aircraft: the paper asks for a free disc, for no strip to roll on, and for no
// limit on the risk.
Aircraft PaperAircraft(Aircraft aircraft);

// A region, and the wind at its centre.
struct Candidate {
  Region region;
  std::optional<WindEstimate> wind;
};

// What the plan of the region depends on.
PlanRequest RequestOf(const Candidate& candidate, int min_num_observations);

// Copy of the frontend's state for the backend, so that both can run concurrently.
struct Snapshot {
  Rig rig;
  std::vector<View> views;
  // Same order as views.
  std::vector<KindPicture> kinds;
  // Best first.
  std::vector<Candidate> regions;
  int min_num_observations = 2;
  std::vector<WindSample> wind_samples;
  // What photographs do not show; the caller sets them.
  std::vector<HardObstacle> obstacles;
};

// A square of the world: its side times these numbers is its south-western corner.
struct MapSquare {
  int east = 0;
  int north = 0;
};

// An evaluated region, or ground found on the map.
struct Site {
  // The tracked region. Of a site from the map: the rectangle around its ground, and the id of the
  // tracked region that it lies in, 0 if in none.
  Region region;
  // Where a site from the map was found; empty for a region's own site.
  std::optional<MapSquare> square = std::nullopt;
  std::optional<WindEstimate> wind;
  Plan plan;
  // Set if the plan was rejected because of obstacles alone: the plan without them, accepted.
  std::optional<Plan> plan_without_obstacles = std::nullopt;
};

// Horizontal rectangle along the axes of world, metres. A new box is empty.
struct Box {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  void Add(const Eigen::Vector2d& point);
  void Grow(double margin);
  bool IsEmpty() const;
  double DistanceTo(const Eigen::Vector2d& point) const;
  Box Intersection(const Box& other) const;
};

// Box around the regions, grown by max_surroundings_m.
Box AreaAround(const std::vector<Candidate>& regions, const BackendOptions& options);

// Box around the ground that the views see. Empty without views.
Box PhotographedArea(const Snapshot& snapshot);

// The key-frames that see an area.
struct Selection {
  std::vector<View> views;
  // Indices of `views` in the snapshot, ascending.
  std::vector<size_t> indices;
  // Number of key-frames that see the area, including those dropped because of max_num_views.
  size_t num_seeing = 0;
};
Selection SelectViews(const Snapshot& snapshot,
                      const Box& area,
                      const AdjustmentOptions& adjustment,
                      const BackendOptions& options);

// Bounding box of an adjusted block's landmarks, with a margin.
Box SeenArea(const AdjustedBlock& block);

// Regions that are evaluated on one map, best first, and the ground of this map.
struct RegionGroup {
  std::vector<Candidate> regions;
  Box area;
};

// Splits regions into groups, each small enough for one map. The order within a group is kept. A
// farm survey is one group, and its map shows all photographed ground, even if there is no region.
// A cross-country flight has many groups.
std::vector<RegionGroup> GroupRegions(const Snapshot& snapshot,
                                      const std::vector<Candidate>& regions,
                                      const PipelineOptions& options);

// Like AdjustPoses. If the largest group does not contain all views, the photographs are projected
// onto the ground and matched again. The poses are then adjusted with the additional matches.
// Takes the block whose largest group has the most views. Then aligns its sightings at full
// resolution and adjusts once more.
AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options);

// What the connected views say of the ground, with adjusted poses and camera. `indices[i]` is the
// index of the block's view i in the snapshot.
std::vector<KindView> AdjustedKindViews(const Snapshot& snapshot,
                                        const std::vector<size_t>& indices,
                                        const AdjustedBlock& block);

// A finished map, and how many views saw each of its cells.
struct MapOfSites {
  const ElevationMap& map;
  const HazardLayers& layers;
  const cv::Mat1b& num_views;
};

// Adds the best landings anywhere on the map to the sites of the regions: first the best one by
// verdict and risk, then the next at least a strip's length away from all accepted ones, and so on.
// Connected ground is cut along squares, and `plan` plans all pieces, in the same order. A piece is
// given as a region with id 0: what the map shows there. A site that lies in a tracked region gets
// the id and the observations of this region.
using PlanFields = std::function<std::vector<Site>(const std::vector<Region>& fields)>;
std::vector<Site> WithMapSites(std::vector<Site> of_regions,
                               const MapOfSites& on,
                               const Aircraft& aircraft,
                               const PipelineOptions& options,
                               const PlanFields& plan);

}  // namespace freelsd
