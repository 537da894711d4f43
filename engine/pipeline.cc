#include "engine/pipeline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/ground_map.h"
#include "engine/steps.h"

namespace freelsd {
namespace {

std::variant<KindNetwork, Classifier> TellerOf(const GroundModel& model) {
  if (const auto* forest = std::get_if<Classifier>(&model)) return *forest;
  return KindNetwork(std::get<KindModel>(model));
}

class Cancellable {
 public:
  explicit Cancellable(const Progress& progress) : progress_(progress) {}
  void Tell(double done_ratio, const std::string& stage) const {
    if (progress_ && !progress_(done_ratio, stage)) throw std::runtime_error("cancelled");
  }

 private:
  const Progress& progress_;
};

// Progress (share of the whole) after each stage of an evaluation.
constexpr double kAdjustmentDone = 0.2;
constexpr double kStereoDone = 0.85;
constexpr double kLayersDone = 0.9;

std::function<void(double)> TellStereo(const Cancellable& progress) {
  return [&progress](double done_ratio) {
    progress.Tell(kAdjustmentDone + (kStereoDone - kAdjustmentDone) * done_ratio, "stereo");
  };
}

AdjustedBlock AdjustSelection(const Selection& selection,
                              const Camera& camera,
                              const ImageSource& images,
                              const PipelineOptions& options,
                              std::vector<StageReport>& reports) {
  AdjustedBlock block;
  block.note = "fewer than two key-frames see the region";
  if (selection.views.size() < 2) return block;
  block = Timed(reports, "bundle_adjustment", [&] {
    return AdjustAndTie(selection.views, camera, images, options.tracks, options.adjustment);
  });
  reports.back().note = block.EvidenceNote();
  return block;
}

Plan NoTerrain(const Region& region, const std::string& why) {
  Plan plan;
  plan.verdict = Verdict::kRejected;
  plan.reject_reason = RejectReason::kNoTerrain;
  plan.reject_detail = "no pair of views measured a height here" + (why.empty() ? "" : ": " + why);
  plan.touchdown_in_world = region.Center();
  plan.slope = plan.roughness = std::numeric_limits<double>::quiet_NaN();
  return plan;
}

Site PlanSite(const Candidate& candidate,
              int min_num_observations,
              const PlannableGround& ground,
              const Evaluation& evaluation,
              const Aircraft& aircraft,
              const PlanOptions& options) {
  Site site{.region = candidate.region, .wind = candidate.wind, .plan = {}};
  if (evaluation.map.grid.num_rows == 0) {
    site.plan = NoTerrain(candidate.region, evaluation.block.note);
    return site;
  }
  const PlanRequest request = RequestOf(candidate, min_num_observations);
  site.plan = ground.PlanFor(request, aircraft, options);
  if (site.plan.verdict == Verdict::kRejected) {
    site.plan_without_obstacles = ground.PlanWithoutObstacles(request, aircraft, options);
  }
  return site;
}

// One for each candidate. Reports the duration of all.
std::vector<Site> PlanSites(const std::vector<Candidate>& candidates,
                            int min_num_observations,
                            const PlannableGround& ground,
                            const Aircraft& aircraft,
                            const PipelineOptions& options,
                            Evaluation& evaluation) {
  const PlanOptions plan_options{options.approach, options.backend.max_surroundings_m};
  std::vector<Site> sites(candidates.size());
  Timed(evaluation.reports, "approach", [&] {
    ForEachAtOnce(sites.size(), [&](size_t i) {
      sites[i] =
          PlanSite(candidates[i], min_num_observations, ground, evaluation, aircraft, plan_options);
    });
    return 0;
  });
  evaluation.reports.back().count = static_cast<int>(sites.size());
  return sites;
}

// Features that identify a crop are 0.3 to 0.75 m wide. Coarser images do not show them, so the
// client needs a warning.
void WarnOfCoarseImages(Evaluation& evaluation, const PipelineOptions& options) {
  std::vector<double> samplings_m;
  for (const AdjustedView& view : evaluation.block.views) {
    if (!view.is_connected) continue;
    samplings_m.push_back(view.height_above_ground / evaluation.block.camera.MeanFocalPx());
  }
  if (samplings_m.empty()) return;
  const auto middle = samplings_m.begin() + static_cast<std::ptrdiff_t>(samplings_m.size() / 2);
  std::nth_element(samplings_m.begin(), middle, samplings_m.end());
  if (*middle <= options.hazard.cover.max_telling_sampling_m) return;
  evaluation.warnings.push_back(
      "a pixel shows " + std::to_string(std::lround(100.0 * *middle)) +
      " cm of ground: too coarse to detect green crops, water with algae and fences");
}

void WarnOfViews(const Selection& selection, Evaluation& evaluation) {
  if (!evaluation.block.note.empty()) evaluation.warnings.push_back(evaluation.block.note);
  if (selection.num_seeing <= selection.views.size()) return;
  evaluation.warnings.push_back("of " + std::to_string(selection.num_seeing) +
                                " key-frames that see the regions, " +
                                std::to_string(selection.views.size()) + " were used");
}

}  // namespace

Frontend::Frontend(const Rig& rig, const PipelineOptions& options, const GroundModel& model)
    : options_(options),
      teller_(TellerOf(model)),
      rig_(rig),
      tracks_(rig, options.tracks),
      regions_(options.regions) {
  rig_.camera.Check();
  options_.Check();
}

std::vector<FrameResult> Frontend::Process(Frame frame) {
  if (frame.wind_in_world) {
    AddWind({frame.prior.position_in_world, *frame.wind_in_world, frame.timestamp_us});
  }
  return ProcessReady(
      Timed(reports_, "tracks", [&] { return tracks_.Add(std::move(frame)); }));  // III-A, B
}

std::vector<FrameResult> Frontend::Flush() { return ProcessReady(tracks_.Flush()); }

std::vector<FrameResult> Frontend::ProcessReady(std::vector<ReadyFrame> ready) {
  std::vector<FrameResult> results;
  if (std::any_of(ready.begin(), ready.end(), [&](const ReadyFrame& frame) {
        return frame.view && NeedsRefinement(*frame.view);
      })) {
    RefinePoses();
  }
  for (const ReadyFrame& frame : ready) {
    if (frame.view) ProcessView(frame);
    results.push_back({frame.frame.id, frame.view.has_value(), frame.note});
  }
  return results;
}

// One view with known pose: finds its homogeneous segments, their class and their place.
void Frontend::ProcessView(const ReadyFrame& ready) {
  const View& view = tracks_.views()[*ready.view];
  const Segments segments = Timed(reports_, "segmentation", [&] {  // Sec. III-C
    return SegmentFrame(
        ready.frame.image, rig_.camera, view.height_above_ground, options_.segmentation);
  });
  const Labels labels = Timed(reports_, "classification", [&] {  // Sec. III-D
    return TellKinds(ready, segments);
  });
  Timed(reports_, "region_manager", [&] {  // Sec. III-E
    regions_.Update(*ready.view, segments, labels, tracks_);
    return 0;
  });
}

// Keeps what the photograph says of the ground, and returns the class of each segment.
Labels Frontend::TellKinds(const ReadyFrame& ready, const Segments& segments) {
  kinds_.resize(std::max(kinds_.size(), *ready.view + 1));
  KindPicture& picture = kinds_[*ready.view];
  if (const auto* forest = std::get_if<Classifier>(&teller_)) {
    Labels labels = ClassifySegments(segments, *forest, options_.classification);
    picture = PictureOf(segments, labels);
    return labels;
  }
  const double height = tracks_.views()[*ready.view].height_above_ground;
  picture =
      std::get<KindNetwork>(teller_).Tell(ready.frame.image, height / rig_.camera.MeanFocalPx());
  return LabelsOf(segments, picture, options_.classification);
}

// Attitudes from matches and attitudes in survey photographs are wrong by up to several
// degrees.
bool Frontend::NeedsRefinement(size_t view) const {
  const std::vector<View>& views = tracks_.views();
  if (views[view].attitude_source != AttitudeSource::kGiven) return true;
  // Photographs with a longer baseline, as a share of the height, are a survey, not a video.
  constexpr double kSurveyBaselineRatio = 0.2;
  return view > 0 &&
         (views[view].world_from_camera.translation - views[view - 1].world_from_camera.translation)
                 .norm() > kSurveyBaselineRatio * views[view].height_above_ground;
}

// Adjusts the newest views together before they place anything on the ground.
void Frontend::RefinePoses() {
  constexpr size_t kNumNewest = 12;
  const std::vector<View>& views = tracks_.views();
  const size_t first = views.size() > kNumNewest ? views.size() - kNumNewest : 0;
  const std::vector<View> window(views.begin() + static_cast<std::ptrdiff_t>(first), views.end());
  if (window.size() < 3) return;
  const AdjustmentOptions in_flight = InFlight(options_.adjustment);
  const AdjustedBlock block = Timed(reports_, "pose_refinement", [&] {
    return AdjustPoses(WithLongestTracks(window, rig_.camera, in_flight.num_refinement_tracks),
                       rig_.camera,
                       in_flight);
  });
  if (!block.is_usable) return;
  for (size_t i = 0; i < window.size(); ++i) {
    if (block.views[i].is_connected) {
      tracks_.SetPose(first + i, block.views[i].world_from_camera, block.views[i].readout);
    }
  }
}

std::vector<Candidate> Frontend::RankedRegions() const {
  const std::vector<WindSample> samples = RecentWind();
  std::vector<Candidate> candidates;
  for (const Region& region : regions_.Ranked()) {
    candidates.push_back({region, WindAt(region.Center().head<2>(), samples, options_.wind)});
  }
  return candidates;
}

std::vector<WindSample> Frontend::RecentWind() const {
  int64_t now_us = 0;
  for (const View& view : tracks_.views()) now_us = std::max(now_us, view.timestamp_us);
  return RecentSamples(wind_samples_, now_us, options_.wind);
}

Snapshot Frontend::TakeSnapshot() const {
  return {rig_,
          tracks_.views(),
          kinds_,
          RankedRegions(),
          regions_.MinNumObservations(),
          RecentWind(),
          {}};
}

std::vector<StageReport> Frontend::TakeReports() { return std::exchange(reports_, {}); }

std::optional<double> Frontend::GroundHeight() const {
  if (tracks_.views().empty()) return std::nullopt;
  const View& first = tracks_.views().front();
  return first.world_from_camera.translation.z() - first.height_above_ground;
}

void PlanOnMap(const Snapshot& snapshot,
               const std::vector<Candidate>& regions,
               const Aircraft& aircraft,
               const PipelineOptions& options,
               Evaluation& evaluation) {
  const PlannableGround ground(
      evaluation.map, evaluation.hazards, snapshot.obstacles, aircraft, options.hazard);
  const auto plan = [&](const std::vector<Candidate>& candidates) {
    return PlanSites(
        candidates, snapshot.min_num_observations, ground, aircraft, options, evaluation);
  };
  evaluation.sites = WithMapSites(
      plan(regions),  // Sec. III-H
      {ground.with_obstacles().map, ground.with_obstacles().layers, evaluation.num_views},
      aircraft,
      options,
      [&](const std::vector<Region>& fields) {
        std::vector<Candidate> candidates;
        for (const Region& field : fields) {
          const Eigen::Vector2d place = field.Center().head<2>();
          candidates.push_back({field, WindAt(place, snapshot.wind_samples, options.wind)});
        }
        return plan(candidates);
      });
}

Evaluation EvaluateSites(const Snapshot& snapshot,
                         const RegionGroup& group,
                         const ImageSource& images,
                         const Aircraft& aircraft,
                         const PipelineOptions& options,
                         const Progress& progress) {
  const Cancellable cancellable(progress);
  Evaluation evaluation;
  cancellable.Tell(0.0, "adjustment");
  const Selection selection =
      SelectViews(snapshot, group.area, options.adjustment, options.backend);  // Sec. III-F
  evaluation.block =
      AdjustSelection(selection, snapshot.rig.camera, images, options, evaluation.reports);
  WarnOfViews(selection, evaluation);
  if (evaluation.block.is_usable) {
    const ElevationMap map = ReconstructMap(evaluation.block,
                                            group.area,
                                            images,
                                            options,
                                            TellStereo(cancellable),
                                            evaluation.reports);  // III-F, G
    cancellable.Tell(kStereoDone, "hazards");
    WarnOfCoarseImages(evaluation, options);
    const std::vector<KindView> kind_views =
        AdjustedKindViews(snapshot, selection.indices, evaluation.block);
    GroundLayers ground = AssessGround(map,
                                       {evaluation.block, kind_views, images},
                                       aircraft,
                                       options.hazard,
                                       evaluation.reports);  // Sec. III-G
    evaluation.map = std::move(ground.map);
    evaluation.hazards = std::move(ground.hazards);
    evaluation.cues = std::move(ground.cues);
    evaluation.num_views = std::move(ground.num_views);
  }
  evaluation.wind =
      WindAt(0.5 * (group.area.min + group.area.max), snapshot.wind_samples, options.wind);
  cancellable.Tell(kLayersDone, "approach");
  PlanOnMap(snapshot, group.regions, aircraft, options, evaluation);
  return evaluation;
}

Evaluation Detect(const Rig& rig,
                  const std::vector<Frame>& frames,
                  const Aircraft& aircraft,
                  const PipelineOptions& options,
                  const GroundModel& model) {
  Frontend frontend(rig, options, model);
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : frames) {
    images[frame.id] = frame.image;
    frontend.Process(frame);
  }
  frontend.Flush();
  std::vector<Candidate> graded;
  for (const Candidate& candidate : frontend.RankedRegions()) {
    if (candidate.region.grade > 0.0) graded.push_back(candidate);
  }
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  const Snapshot snapshot = frontend.TakeSnapshot();
  const RegionGroup group{graded, PhotographedArea(snapshot)};
  Evaluation evaluation = EvaluateSites(snapshot, group, source, aircraft, options, {});
  std::vector<StageReport> reports = frontend.TakeReports();
  evaluation.reports.insert(evaluation.reports.begin(), reports.begin(), reports.end());
  return evaluation;
}

}  // namespace freelsd
