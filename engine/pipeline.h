// The whole method; start reading here. Frontend::Process runs for every frame as it arrives.
// EvaluateSites runs concurrently for the best regions, on a copy of the frontend's state. Detect
// runs both on a stored flight.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/selection/selection.h"

namespace freelsd {

// Result for a frame that the frontend received, now or earlier.
struct FrameResult {
  std::string frame_id;
  bool is_processed = false;
  // The reason why it was not processed, or a warning. Often empty.
  std::string note;
};

class Frontend {
 public:
  Frontend(const Rig& rig, const PipelineOptions& options, const GroundModel& model);

  // Processes one frame as it arrives; must keep up with the image rate. A frame may wait for its
  // neighbours, so the results may be empty or be those of earlier frames.
  std::vector<FrameResult> Process(Frame frame);
  // Takes a wind measured between frames. A frame's own wind comes with the frame.
  void AddWind(const WindSample& sample) { wind_samples_.push_back(sample); }
  // Processes frames that still wait for neighbours.
  std::vector<FrameResult> Flush();

  // Best region first, each with the current wind estimate at its centre.
  std::vector<Candidate> RankedRegions() const;
  Snapshot TakeSnapshot() const;
  std::vector<StageReport> TakeReports();
  // Height of the ground below the first view, world z; unknown before any view.
  std::optional<double> GroundHeight() const;

 private:
  std::vector<FrameResult> ProcessReady(std::vector<ReadyFrame> ready);
  bool NeedsRefinement(size_t view) const;
  void RefinePoses();
  void ProcessView(const ReadyFrame& ready);
  Labels TellKinds(const ReadyFrame& ready, const Segments& segments);
  std::vector<WindSample> RecentWind() const;

  PipelineOptions options_;
  std::variant<KindNetwork, Classifier> teller_;
  Rig rig_;
  Tracks tracks_;
  Regions regions_;
  std::vector<KindPicture> kinds_;
  std::vector<WindSample> wind_samples_;
  std::vector<StageReport> reports_;
};

struct Evaluation {
  // One site per requested region, in the same order, followed by those from the map (see
  // WithMapSites).
  std::vector<Site> sites;
  // The map and its layers are shared by all sites. Their grids are empty if nothing was
  // reconstructed. The map includes its cover (WithCover).
  ElevationMap map;
  HazardLayers hazards;
  // What told grass from other ground, cell by cell.
  std::vector<CueLayer> cues;
  // Views that saw each cell; empty without a map.
  cv::Mat1b num_views;
  // At the middle of the map.
  std::optional<WindEstimate> wind;
  AdjustedBlock block;
  std::vector<StageReport> reports;
  std::vector<std::string> warnings;
};

// Evaluates a group of regions on one shared map. The map does not depend on the aircraft. Calls
// `progress` with the completed share 0..1 and the
// current stage. If `progress` returns false, throws std::runtime_error("cancelled").
using Progress = std::function<bool(double done_ratio, const std::string& stage)>;
Evaluation EvaluateSites(const Snapshot& snapshot,
                         const RegionGroup& group,
                         const ImageSource& images,
                         const Aircraft& aircraft,
                         const PipelineOptions& options,
                         const Progress& progress);

// The last stage of EvaluateSites: plans the regions and sites found anywhere on the evaluation's
// map, and sets its sites.
void PlanOnMap(const Snapshot& snapshot,
               const std::vector<Candidate>& regions,
               const Aircraft& aircraft,
               const PipelineOptions& options,
               Evaluation& evaluation);

// Processes a whole stored flight. The frontend processes all frames. Then all regions with a grade
// above 0 are evaluated.
Evaluation Detect(const Rig& rig,
                  const std::vector<Frame>& frames,
                  const Aircraft& aircraft,
                  const PipelineOptions& options,
                  const GroundModel& model);

}  // namespace freelsd
