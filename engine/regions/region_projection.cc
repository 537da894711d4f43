#include <algorithm>

#include "engine/regions/region_update.h"
#include "engine/regions/regions.h"

namespace freelsd {
namespace {

// Rectangle around a segment's contour, brought to the ground; nothing where a corner looks at or
// above the horizon.
std::optional<Detection> Project(size_t view,
                                 const Segment& segment,
                                 const Label& label,
                                 const Tracks& tracks,
                                 const RegionsOptions& options) {
  const Polygon rectangle = MinAreaRectangle(segment.contour_in_image);
  if (rectangle.size() != 4) return std::nullopt;
  Detection detection;
  detection.is_grass = label.surface == Surface::kGrass;
  detection.is_fully_visible = !segment.touches_border;
  Polygon on_ground;
  double height = 0.0;
  for (const Eigen::Vector2d& corner : rectangle) {
    detection.is_fully_visible &= tracks.camera().IsInside(corner, options.border_margin_px);
    const std::optional<GroundPoint> ground = tracks.GroundAt(view, corner);
    if (!ground) return std::nullopt;
    on_ground.push_back(ground->point_in_world.head<2>());
    height += 0.25 * ground->point_in_world.z();
  }
  // Seen from above the image's y axis points down: its counter-clockwise is the ground's
  // clockwise.
  if (SignedArea(on_ground) < 0.0) std::reverse(on_ground.begin(), on_ground.end());
  for (const Eigen::Vector2d& corner : on_ground) {
    detection.corners_in_world.emplace_back(corner.x(), corner.y(), height);
  }
  const std::optional<GroundPoint> centroid = tracks.GroundAt(view, Centroid(rectangle));
  if (!centroid) return std::nullopt;
  detection.centroid_in_world = centroid->point_in_world.head<2>();
  return detection;
}

// Ground that a view sees, and its middle; nothing for a view that sees the horizon.
std::optional<ViewFootprint> FootprintOf(size_t view, const Tracks& tracks) {
  const Camera& camera = tracks.camera();
  const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
  ViewFootprint footprint;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0),
                                        Eigen::Vector2d(right, 0),
                                        Eigen::Vector2d(right, bottom),
                                        Eigen::Vector2d(0, bottom)}) {
    const std::optional<GroundPoint> ground = tracks.GroundAt(view, corner);
    if (!ground) return std::nullopt;
    footprint.ground.push_back(ground->point_in_world.head<2>());
  }
  footprint.middle = Centroid(footprint.ground);
  return footprint;
}

}  // namespace

void Regions::Update(size_t view,
                     const Segments& segments,
                     const Labels& labels,
                     const Tracks& tracks) {
  std::vector<Detection> detections;
  for (size_t i = 0; i < segments.segments.size(); ++i) {
    if (auto detection = Project(view, segments.segments[i], labels[i], tracks, options_)) {
      detections.push_back(std::move(*detection));
    }
  }
  const View& seen = tracks.views()[view];
  const ViewStamp stamp{view, seen.frame_id, seen.timestamp_us};
  UpdateRegions(stamp, detections, regions_, next_id_);
  CountView(FootprintOf(view, tracks));
  GradeRegions(stamp, min_num_observations_, options_, regions_);
  KeepBest(options_.max_num_regions, regions_);
}

// Half of how often the flight lets a place be seen: the median over the views' middles.
void Regions::CountView(const std::optional<ViewFootprint>& footprint) {
  if (!footprint) return;
  footprints_.push_back(*footprint);
  num_views_of_middle_.push_back(1);
  for (size_t i = 0; i + 1 < footprints_.size(); ++i) {
    num_views_of_middle_[i] += Contains(footprint->ground, footprints_[i].middle) ? 1 : 0;
    num_views_of_middle_.back() += Contains(footprints_[i].ground, footprint->middle) ? 1 : 0;
  }
  std::vector<int> sorted = num_views_of_middle_;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  min_num_observations_ = std::clamp(sorted[sorted.size() / 2] / 2,
                                     options_.min_num_observations_floor,
                                     options_.min_num_observations);
}

}  // namespace freelsd
