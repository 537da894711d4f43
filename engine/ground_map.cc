#include "engine/ground_map.h"

#include <algorithm>
#include <deque>
#include <span>
#include <string>
#include <utility>

#include "engine/mosaic/mosaic.h"
#include "engine/steps.h"

namespace freelsd {
namespace {

// Keeps the last few full-size images, because consecutive pairs share them.
class ImageCache {
 public:
  explicit ImageCache(const ImageSource& source) : source_(source) {}

  // Loads those that are missing.
  void Load(const std::vector<std::string>& frame_ids) {
    std::vector<std::string> missing;
    for (const std::string& id : frame_ids) {
      const bool is_new = std::find(missing.begin(), missing.end(), id) == missing.end();
      if (is_new && !Find(id)) missing.push_back(id);
    }
    std::vector<cv::Mat> loaded(missing.size());
    ForEachAtOnce(missing.size(), [&](size_t i) { loaded[i] = source_(missing[i]); });
    for (size_t i = 0; i < missing.size(); ++i) images_.emplace_back(missing[i], loaded[i]);
    while (images_.size() > std::max(kMaxNumImages, frame_ids.size())) images_.pop_front();
  }
  // Of those loaded last.
  cv::Mat At(const std::string& frame_id) const {
    const cv::Mat* const image = Find(frame_id);
    return image ? *image : source_(frame_id);
  }

 private:
  static constexpr size_t kMaxNumImages = 6;

  const cv::Mat* Find(const std::string& frame_id) const {
    for (const auto& [id, image] : images_) {
      if (id == frame_id) return &image;
    }
    return nullptr;
  }

  const ImageSource& source_;
  std::deque<std::pair<std::string, cv::Mat>> images_;
};

Points SparsePoints(const AdjustedBlock& block) {
  Points points;
  for (const Landmark& landmark : block.landmarks) {
    points.push_back(
        {landmark.point_in_world.cast<float>(), static_cast<float>(landmark.height_sd_m)});
  }
  return points;
}

// Points of each pair. The reported duration is that of all.
std::vector<Points> ReconstructSome(const AdjustedBlock& block,
                                    std::span<const StereoPair> pairs,
                                    ImageCache& cache,
                                    const StereoOptions& options,
                                    std::vector<StageReport>& reports) {
  std::vector<std::string> frame_ids;
  for (const StereoPair& pair : pairs) {
    frame_ids.push_back(block.views[pair.left].frame_id);
    frame_ids.push_back(block.views[pair.right].frame_id);
  }
  cache.Load(frame_ids);
  std::vector<Points> points(pairs.size());
  Timed(reports, "stereo", [&] {
    ForEachAtOnce(pairs.size(), [&](size_t i) {
      const cv::Mat left = cache.At(frame_ids[2 * i]), right = cache.At(frame_ids[2 * i + 1]);
      if (left.empty() || right.empty()) return;
      points[i] = ReconstructPoints(block, pairs[i], left, right, options);
    });
    return 0;
  });
  reports.back().count = static_cast<int>(pairs.size());
  return points;
}

}  // namespace

ElevationMap ReconstructMap(const AdjustedBlock& block,
                            const Box& area,
                            const ImageSource& images,
                            const PipelineOptions& options,
                            const std::function<void(double done_ratio)>& progress,
                            std::vector<StageReport>& reports) {
  const Box box = area.Intersection(SeenArea(block));
  if (box.IsEmpty()) return {};
  ElevationMapBuilder builder(GridAround(box.min, box.max, options.terrain.cell_size_m),
                              options.terrain);
  const std::vector<StereoPair> pairs = SelectPairs(block, options.stereo);
  ImageCache cache(images);
  const auto num_at_once = static_cast<size_t>(std::max(1, cv::getNumThreads()));
  for (size_t first = 0; first < pairs.size(); first += num_at_once) {
    progress(static_cast<double>(first) / static_cast<double>(pairs.size()));
    const std::span<const StereoPair> some =
        std::span(pairs).subspan(first, std::min(num_at_once, pairs.size() - first));
    for (const Points& points : ReconstructSome(block, some, cache, options.stereo, reports)) {
      if (!points.empty()) Timed(reports, "elevation", [&] { return builder.Add(points), 0; });
    }
  }
  builder.Add(SparsePoints(block));
  ElevationMap map = Timed(reports, "elevation_fusion", [&] { return builder.Build(); });
  map.position_sd_m = block.position_sd_m;
  map.tilt_sd_deg = block.tilt_sd_deg;
  return map;
}

GroundLayers AssessGround(const ElevationMap& map,
                          const GroundPhotos& photos,
                          const Aircraft& aircraft,
                          HazardOptions options,
                          std::vector<StageReport>& reports) {
  if (map.is_compared) options.cover.photo.max_photo_disagreement = 0.0;  // all were compared
  Orthophoto photo = Timed(reports, "orthophoto", [&] {
    return MakeOrthophoto(map, photos.block, photos.images, options.cover.photo);
  });
  const GroundSurface surface =
      Timed(reports, "surface", [&] { return MeasureSurface(map, options.surface); });
  GroundCover cover = Timed(reports, "cover", [&] {
    return AssessCover(map, surface, photos.kind_views, options.cover, std::move(photo));
  });
  AssessedMap finished = Timed(reports, "hazard_layers", [&] {
    return AssessHazards(
        map, surface, cover, {aircraft.max_slope_deg, aircraft.max_roughness_m}, options);
  });
  GroundLayers ground;
  ground.map = std::move(finished.map);
  ground.hazards = std::move(finished.layers);
  ground.cues = std::move(cover.cues);
  ground.num_views = NumViewsOf(ground.map, photos.block);
  return ground;
}

}  // namespace freelsd
