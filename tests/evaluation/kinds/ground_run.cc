#include "tests/evaluation/kinds/ground_run.h"

namespace freelsd {
namespace {

// Without what the kinds do not need.
PipelineOptions WithoutRules(PipelineOptions options) {
  CoverOptions& cover = options.hazard.cover;
  cover.min_rut_contrast = cover.min_row_strength = cover.min_detail_ratio = 0.0;
  cover.min_overreach_deviations = cover.min_object_deviations = cover.min_fence_deviations = 0.0;
  cover.photo.max_photo_disagreement = 0.0;
  return options;
}

}  // namespace

GroundRun RunGround(const Rig& rig,
                    const std::vector<Frame>& frames,
                    const Classifier& classifier,
                    const PipelineOptions& options) {
  const PipelineOptions plain = WithoutRules(options);
  Frontend frontend(rig, plain, classifier);
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : frames) {
    images[frame.id] = frame.image;
    frontend.Process(frame);
  }
  frontend.Flush();
  const Snapshot snapshot = frontend.TakeSnapshot();
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  const RegionGroup group{{}, PhotographedArea(snapshot)};
  GroundRun run;
  run.evaluation = EvaluateSites(snapshot, group, source, Aircraft{}, plain, {});
  const Selection selection = SelectViews(snapshot, group.area, plain.adjustment, plain.backend);
  run.grass_views = AdjustedGrassViews(snapshot, selection.indices, run.evaluation.block);
  run.photo =
      MakeOrthophoto(run.evaluation.map, run.evaluation.block, source, options.hazard.cover.photo);
  return run;
}

std::array<cv::Mat1f, kNumCues> CuesOf(const GroundRun& run, const PipelineOptions& options) {
  const ElevationMap& map = run.evaluation.map;
  const GroundSurface surface = MeasureSurface(map, options.hazard.surface);
  std::array<cv::Mat1f, kNumCues> cues;
  VisitCues(
      {map, surface, run.grass_views, run.photo},
      options.hazard.cover,
      [&](Cue cue, const cv::Mat1f& values) { cues[static_cast<size_t>(cue)] = values.clone(); });
  return cues;
}

}  // namespace freelsd
