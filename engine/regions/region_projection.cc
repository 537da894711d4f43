#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/regions/region_update.h"

namespace freelsd {
namespace {

// If an image corner looks at or above the horizon, a point at the first of these shares of the way
// from the image centre that sees ground replaces it.
constexpr double kFootprintShares[] = {1.0, 0.75, 0.5, 0.25};

// Ground at a pixel; nothing if it is too far away to be trusted.
std::optional<Eigen::Vector3d> TrustedGround(const Tracks& tracks,
                                             size_t view,
                                             const Eigen::Vector2d& point_in_image,
                                             double max_distance_ratio) {
  const std::optional<GroundPoint> ground = tracks.GroundAt(view, point_in_image);
  if (!ground || !ground->point_in_world.allFinite()) return std::nullopt;
  const View& seen_from = tracks.views()[view];
  const double distance = (ground->point_in_world - seen_from.world_from_camera.translation).norm();
  if (distance > max_distance_ratio * seen_from.height_above_ground) return std::nullopt;
  return ground->point_in_world;
}

std::vector<Eigen::Vector3d> CounterClockwise(std::vector<Eigen::Vector3d> corners_in_world) {
  if (SignedArea(GroundPolygon(corners_in_world)) < 0.0) {
    std::reverse(corners_in_world.begin(), corners_in_world.end());
  }
  return corners_in_world;
}

bool IsFullyVisible(const Segment& segment,
                    const Polygon& rectangle_in_image,
                    const Camera& camera,
                    double margin_px) {
  return !segment.touches_border &&
         std::all_of(rectangle_in_image.begin(), rectangle_in_image.end(), [&](const auto& corner) {
           return camera.IsInside(corner, margin_px);
         });
}

// Nothing if a corner does not hit the ground, or the rectangle has no area.
std::optional<Detection> ProjectSegment(const Segment& segment,
                                        size_t view,
                                        const Tracks& tracks,
                                        const RegionsOptions& options) {
  const Polygon rectangle = MinAreaRectangle(segment.contour_in_image);
  if (rectangle.size() != 4) return std::nullopt;
  Detection detection;
  for (const Eigen::Vector2d& corner : rectangle) {
    const auto ground = TrustedGround(tracks, view, corner, options.max_viewing_distance_ratio);
    if (!ground) return std::nullopt;
    detection.corners_in_world.push_back(*ground);
  }
  const auto centroid =
      TrustedGround(tracks, view, Centroid(rectangle), options.max_viewing_distance_ratio);
  if (!centroid) return std::nullopt;
  detection.centroid_in_world = *centroid;
  detection.corners_in_world = CounterClockwise(std::move(detection.corners_in_world));
  detection.is_fully_visible =
      IsFullyVisible(segment, rectangle, tracks.camera(), options.border_margin_px);
  detection.area_m2 = segment.area_m2;
  return detection;
}

Polygon ViewFootprint(size_t view, const Tracks& tracks, double max_distance_ratio) {
  const Camera& camera = tracks.camera();
  const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
  const Eigen::Vector2d center(0.5 * right, 0.5 * bottom);
  Polygon footprint;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0.0, 0.0),
                                        Eigen::Vector2d(right, 0.0),
                                        Eigen::Vector2d(right, bottom),
                                        Eigen::Vector2d(0.0, bottom)}) {
    for (const double share : kFootprintShares) {
      const auto ground =
          TrustedGround(tracks, view, center + share * (corner - center), max_distance_ratio);
      if (!ground) continue;
      footprint.push_back(ground->head<2>());
      break;
    }
  }
  return footprint;
}

}  // namespace

void Regions::Update(size_t view,
                     const Segments& segments,
                     const Labels& labels,
                     const Tracks& tracks) {
  if (labels.size() != segments.segments.size()) {
    throw std::invalid_argument("regions.labels: " + std::to_string(labels.size()) + " for " +
                                std::to_string(segments.segments.size()) + " segments");
  }
  const RegionsOptions& options = state_->options;
  const Camera& camera = tracks.camera();
  const Eigen::Vector2d image_center(0.5 * (camera.width_px - 1), 0.5 * (camera.height_px - 1));
  if (const auto center =
          TrustedGround(tracks, view, image_center, options.max_viewing_distance_ratio)) {
    state_->overlap.Add(
        view, center->head<2>(), ViewFootprint(view, tracks, options.max_viewing_distance_ratio));
  }
  std::vector<Detection> detections;
  for (size_t i = 0; i < labels.size(); ++i) {
    auto detection = ProjectSegment(segments.segments[i], view, tracks, options);
    if (!detection) continue;
    detection->is_grass = labels[i].surface == Surface::kGrass;
    detections.push_back(std::move(*detection));
  }
  const View& seen = tracks.views()[view];
  state_->tracker.Update(
      {.view = view, .frame_id = seen.frame_id, .timestamp_us = seen.timestamp_us},
      std::move(detections),
      MinNumObservations());
}

}  // namespace freelsd
