// The method, start here. Frontend::Process runs for every frame as it arrives; EvaluateSites runs
// beside it, on a copy, for the most promising regions. Detect drives both for a stored flight.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
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
  // Key-frames that may take part in one evaluation. Regions that need more are evaluated in
  // groups; of a single region's the ones nearest to its middle are taken.
  int max_num_views = 300;
  // Regions farther apart than this are evaluated in groups, each on a map of its own.
  double max_group_extent_m = 1500.0;
  // Further fields within the rectangle of one region that get a site. Differs: the paper's region
  // has one, but grass hangs together through gaps in hedges, and the rectangle around it all holds
  // many fields. 0 is the paper's.
  int max_num_further_fields = 12;
  // What hangs together is looked at in pieces of this extent; touchdowns of one region lie at
  // least half of it apart.
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

// What became of a frame that was given to the frontend, now or earlier.
struct FrameResult {
  std::string frame_id;
  bool is_processed = false;
  // Why not, or a warning.
  std::string note;
};

// A view's grass mask in little memory: a flight has one for each of its frames.
struct PackedMask {
  // Pixels in a row that have one value, row after row.
  struct Run {
    uint8_t value = 0;
    uint32_t length = 0;
  };
  cv::Size size;
  std::vector<Run> runs;
  // As GrassView.
  double image_px_per_mask_px = 1.0;

  cv::Mat1b Unpack() const;
};

// Everything the backend needs of the frontend, copied, so that both run at once.
struct Snapshot {
  Rig rig;
  std::vector<View> views;
  // Same order as views.
  std::vector<PackedMask> grass_masks;
  std::vector<Region> regions;
  int min_num_observations = 2;
  std::vector<WindSample> wind_samples;
};

class Frontend {
 public:
  Frontend(const Rig& rig, const PipelineOptions& options, Classifier classifier);

  // One frame, as it arrives; must keep up with the image rate. Frames may have to wait for their
  // neighbours, so the answer can speak of none, or of earlier ones.
  std::vector<FrameResult> Process(Frame frame);
  // No more frames for now.
  std::vector<FrameResult> Flush();

  std::vector<Region> RankedRegions() const;
  // As in the snapshot.
  std::vector<WindSample> RecentWind() const;
  Snapshot TakeSnapshot() const;
  std::vector<StageReport> TakeReports();
  // Height of the ground below the first view, world z; unknown before any view.
  std::optional<double> GroundHeight() const;

 private:
  std::vector<FrameResult> ProcessReady(std::vector<ReadyFrame> ready);
  bool NeedsRefinement(size_t view) const;
  void RefinePoses();
  void ProcessView(const ReadyFrame& ready);

  PipelineOptions options_;
  Classifier classifier_;
  Rig rig_;
  Tracks tracks_;
  Regions regions_;
  std::vector<PackedMask> grass_masks_;
  std::vector<WindSample> wind_samples_;
  std::vector<StageReport> reports_;
};

// A region in depth.
struct Site {
  // For a further field the rectangle around that field alone, else as tracked.
  Region region;
  // 1 for the region's own site. A rectangle may hold several fields, and one may be good where
  // another is better: from 2 on, the others.
  int field_number = 1;
  std::optional<WindEstimate> wind;
  Plan plan;
};

struct Evaluation {
  // One per region that was asked for, same order; then further fields of these, accepted ones
  // only.
  std::vector<Site> sites;
  // Shared by all sites; empty grids when nothing could be reconstructed.
  ElevationMap map;
  HazardLayers hazards;
  AdjustedBlock block;
  std::vector<StageReport> reports;
  std::vector<std::string> warnings;
};

// Groups of regions that can be evaluated on one map, best first within each. A survey of a farm is
// one group; a flight across the country has many.
std::vector<std::vector<Region>> GroupRegions(const Snapshot& snapshot,
                                              const std::vector<Region>& regions,
                                              const Aircraft& aircraft,
                                              const PipelineOptions& options);

// The regions in depth, on one map of them all. `progress` is told 0..1 and the stage; when it
// answers false the evaluation ends with std::runtime_error("cancelled").
using Progress = std::function<bool(double done_ratio, const std::string& stage)>;
Evaluation EvaluateSites(const Snapshot& snapshot,
                         const std::vector<Region>& regions,
                         const ImageSource& images,
                         const Aircraft& aircraft,
                         const PipelineOptions& options,
                         const Progress& progress);

// A whole stored flight: every frame through the frontend, then every region with a grade.
Evaluation Detect(const Rig& rig,
                  const std::vector<Frame>& frames,
                  const Aircraft& aircraft,
                  const PipelineOptions& options,
                  const Classifier& classifier);

}  // namespace freelsd
