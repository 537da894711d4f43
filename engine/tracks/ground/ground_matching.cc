#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/tracks/descriptor_matching.h"
#include "engine/tracks/ground/ground_image.h"
#include "engine/tracks/ground/overlap.h"
#include "engine/tracks/keypoints.h"
#include "engine/tracks/track_table.h"
#include "engine/tracks/tracks.h"
#include "engine/tracks/verification.h"

namespace freelsd {
namespace {

// A view's data for matching: places on level ground and their pixels in the image.
struct GroundPoints {
  DescribedPoints on_ground;
  std::vector<Eigen::Vector2d> in_image;
};

GroundPoints DescribeGround(const View& view,
                            const Camera& camera,
                            const cv::Mat& image,
                            const TracksOptions& options) {
  // Corners this near to the border are artefacts of the border.
  constexpr double kBorderPx = 8.0;
  GroundPoints points;
  const GroundImage ground = SeenFromAbove(view, camera, image, options.ground_matching_width_px);
  if (ground.grey.empty()) return points;
  TracksOptions finer = options;
  finer.max_num_keypoints = options.max_num_ground_keypoints;
  const DescribedPoints described = DescribeKeypoints({ground.grey, 1.0}, finer);
  const Rigid3d camera_from_world = Inverse(view.world_from_camera);
  for (size_t i = 0; i < described.points.size(); ++i) {
    const Eigen::Vector3d place = ground.WorldFromPixel(described.points[i]);
    const auto pixel = camera.ImageFromCamera(camera_from_world * place);
    if (!pixel || !camera.IsInside(*pixel, kBorderPx)) continue;
    points.on_ground.points.push_back(place.head<2>());
    points.on_ground.descriptors.push_back(described.descriptors.row(static_cast<int>(i)));
    points.in_image.push_back(*pixel);
  }
  return points;
}

// Views that overlap a view of another group.
std::vector<bool> BorderViews(const std::vector<ViewPair>& pairs, const std::vector<int>& group) {
  std::vector<bool> is_border(group.size(), false);
  for (const auto& [i, j, ratio] : pairs) {
    if (group[i] == group[j] && group[i] >= 0) continue;
    is_border[i] = is_border[j] = true;
  }
  return is_border;
}

// Ideal pixels at the width for which the verification threshold is given.
std::vector<Eigen::Vector2d> IdealPixels(const Camera& camera,
                                         const GroundPoints& points,
                                         const std::vector<int>& indices,
                                         double scale) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(indices.size());
  for (const int i : indices) {
    pixels.push_back(camera.NormalizedFromImage(points.in_image[static_cast<size_t>(i)]) *
                     (camera.MeanFocalPx() * scale));
  }
  return pixels;
}

std::vector<IndexPair> MatchOnGround(const Camera& camera_a,
                                     const GroundPoints& a,
                                     const Camera& camera_b,
                                     const GroundPoints& b,
                                     double radius_m,
                                     const TracksOptions& options) {
  const std::vector<IndexPair> matches = MatchDescriptorsNear(a.on_ground, b.on_ground, radius_m);
  std::vector<int> of_a, of_b;
  for (const IndexPair& match : matches) {
    of_a.push_back(match.a);
    of_b.push_back(match.b);
  }
  const double scale =
      std::min(1.0, static_cast<double>(options.matching_width_px) / camera_a.width_px);
  std::vector<IndexPair> verified;
  for (const int index : VerifyMatches(IdealPixels(camera_a, a, of_a, scale),
                                       IdealPixels(camera_b, b, of_b, scale),
                                       options.max_verification_error_px,
                                       options.min_num_tie_matches)) {
    verified.push_back(matches[static_cast<size_t>(index)]);
  }
  return verified;
}

// Appends observations with new ids to those of the views.
void AppendTracks(const TrackTable& table, std::vector<View>& views) {
  int64_t first_id = 0;
  for (const View& view : views) {
    for (const Observation& seen : view.observations) {
      first_id = std::max(first_id, seen.track_id + 1);
    }
  }
  for (size_t i = 0; i < views.size(); ++i) {
    for (const Observation& seen : table.ObservationsOf(i)) {
      views[i].observations.push_back({first_id + seen.track_id, seen.point_in_image});
    }
  }
}

}  // namespace

std::vector<View> TieOnGround(std::vector<View> views,
                              const std::vector<int>& group,
                              const Camera& camera,
                              const ImageSource& images,
                              const TracksOptions& options) {
  const std::vector<ViewPair> pairs =
      OverlappingPairs(views, camera, options.min_ground_overlap_ratio);
  const std::vector<bool> is_border = BorderViews(pairs, group);
  std::vector<GroundPoints> points(views.size());
  cv::parallel_for_({0, static_cast<int>(views.size())}, [&](const cv::Range& range) {
    for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
      if (!is_border[i]) continue;
      const cv::Mat image = images(views[i].frame_id);
      if (image.empty()) continue;
      points[i] = DescribeGround(views[i], camera.With(views[i].readout), image, options);
    }
  });
  std::vector<std::vector<IndexPair>> matches(pairs.size());
  cv::parallel_for_({0, static_cast<int>(pairs.size())}, [&](const cv::Range& range) {
    for (auto k = static_cast<size_t>(range.start); k < static_cast<size_t>(range.end); ++k) {
      const auto [i, j, ratio] = pairs[k];
      const double radius_m = options.max_ground_error_ratio *
                              std::max(views[i].height_above_ground, views[j].height_above_ground);
      matches[k] = MatchOnGround(camera.With(views[i].readout),
                                 points[i],
                                 camera.With(views[j].readout),
                                 points[j],
                                 radius_m,
                                 options);
    }
  });
  TrackTable table;
  for (size_t i = 0; i < views.size(); ++i) table.AddFrame();
  for (size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j, ratio] = pairs[k];
    for (const IndexPair& match : matches[k]) {
      table.Join({i, match.a, points[i].in_image[static_cast<size_t>(match.a)]},
                 {j, match.b, points[j].in_image[static_cast<size_t>(match.b)]});
    }
  }
  AppendTracks(table, views);
  return views;
}

}  // namespace freelsd
