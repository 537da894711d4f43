#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "engine/tracks/coarse_depth.h"
#include "engine/tracks/ground/overlap.h"
#include "engine/tracks/keypoints.h"
#include "engine/tracks/prediction.h"
#include "engine/tracks/tracks.h"
#include "engine/tracks/verification.h"

namespace freelsd {
namespace {

// Points are chosen evenly from this many parts of a photograph along each side.
constexpr int kNumPartsAcross = 8;

// A point of a track in a view, and where another view should show it.
struct TiePoint {
  int64_t track_id = 0;
  size_t num_views = 0;
  double world_z = 0.0;
  Eigen::Vector2d point_in_from = Eigen::Vector2d::Zero();
  Eigen::Vector2d guess_in_to = Eigen::Vector2d::Zero();
};

class OverlapFollower {
 public:
  OverlapFollower(const std::vector<View>& views,
                  const TrackPoints& points,
                  const Camera& camera,
                  const ImageSource& images,
                  const TracksOptions& options)
      : views_(views),
        points_(points),
        camera_(camera),
        options_(options),
        reduced_(views.size()),
        seen_(views.size()) {
    for (size_t i = 0; i < views.size(); ++i) {
      for (const Observation& observation : views[i].observations) {
        if (!points.contains(observation.track_id)) continue;
        seen_[i].emplace(observation.track_id, observation.point_in_image);
        ++num_views_of_[observation.track_id];
      }
    }
    cv::parallel_for_({0, static_cast<int>(views.size())}, [&](const cv::Range& range) {
      for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
        const cv::Mat image = images(views[i].frame_id);
        if (!image.empty()) reduced_[i] = ReduceForTracking(image, options);
      }
    });
  }

  // For each view, those from which points are followed into it: views that overlap it and share
  // too few points with it, at least the num_tie_partners that show most of the same ground.
  std::vector<std::vector<size_t>> Partners() const {
    std::vector<ViewPair> pairs = OverlappingPairs(views_, camera_, options_.min_tie_overlap_ratio);
    std::erase_if(pairs, [&](const ViewPair& pair) {
      return NumShared(pair) >= options_.max_num_shared_points;
    });
    std::stable_sort(pairs.begin(), pairs.end(), [](const ViewPair& a, const ViewPair& b) {
      return a.overlap_ratio > b.overlap_ratio;
    });
    const auto max_num = static_cast<size_t>(options_.num_tie_partners);
    std::vector<std::vector<size_t>> partners(views_.size());
    for (const auto& [first, second, ratio] : pairs) {
      if (std::min(partners[first].size(), partners[second].size()) >= max_num) continue;
      partners[first].push_back(second);
      partners[second].push_back(first);
    }
    return partners;
  }

  // Sightings in `to` of points of the other views; of each track the first that is found.
  std::vector<Observation> Follow(const std::vector<size_t>& partners, size_t to) const {
    if (partners.empty() || reduced_[to].grey.empty()) return {};
    PosedImage posed_to = PosedImageOf(to);
    posed_to.image = WithPyramid(std::move(posed_to.image));
    std::vector<Observation> found;
    std::set<int64_t> known;
    for (const size_t from : partners) {
      for (const Observation& sighting : FollowFrom(from, to, posed_to)) {
        if (known.insert(sighting.track_id).second) found.push_back(sighting);
      }
    }
    return found;
  }

 private:
  PosedImage PosedImageOf(size_t view) const {
    return {reduced_[view], camera_.With(views_[view].readout), views_[view].world_from_camera};
  }

  std::vector<Observation> FollowFrom(size_t from, size_t to, const PosedImage& posed_to) const {
    if (reduced_[from].grey.empty()) return {};
    const std::vector<TiePoint> ties = ChooseTies(from, to);
    if (static_cast<int>(ties.size()) < options_.min_num_tie_matches) return {};
    const PosedImage posed_from = PosedImageOf(from);
    const auto overlap = OverlapOverGround(posed_from, posed_to, MedianHeight(ties));
    if (!overlap) return {};
    std::vector<Eigen::Vector2d> places, guesses;
    for (const TiePoint& tie : ties) {
      places.push_back(tie.point_in_from);
      guesses.push_back(tie.guess_in_to);
    }
    const auto followed =
        FollowOverGround(posed_from, posed_to, *overlap, places, guesses, options_);
    return Verified(posed_from, posed_to, ties, followed);
  }

  int NumShared(const ViewPair& pair) const {
    const auto& other = seen_[pair.second];
    return static_cast<int>(
        std::count_if(seen_[pair.first].begin(), seen_[pair.first].end(), [&](const auto& point) {
          return other.contains(point.first);
        }));
  }

  // Points of `from` that `to` shows but that are not known there, evenly spread; those of the
  // longest tracks first.
  std::vector<TiePoint> ChooseTies(size_t from, size_t to) const {
    const Camera camera = camera_.With(views_[to].readout);
    const Rigid3d to_from_world = Inverse(views_[to].world_from_camera);
    std::map<std::pair<int, int>, std::vector<TiePoint>> parts;
    for (const auto& [id, point_in_from] : seen_[from]) {
      if (seen_[to].contains(id)) continue;
      const Eigen::Vector3d& point = points_.at(id);
      const auto guess = camera.ImageFromCamera(to_from_world * point);
      if (!guess || !camera.IsInside(*guess)) continue;
      const std::pair<int, int> part(
          static_cast<int>(guess->x() * kNumPartsAcross / camera.width_px),
          static_cast<int>(guess->y() * kNumPartsAcross / camera.height_px));
      parts[part].push_back({id, num_views_of_.at(id), point.z(), point_in_from, *guess});
    }
    for (auto& [part, ties] : parts) {
      std::stable_sort(ties.begin(), ties.end(), [](const TiePoint& a, const TiePoint& b) {
        return a.num_views > b.num_views;
      });
    }
    std::vector<TiePoint> chosen;
    const auto num_wanted = static_cast<size_t>(options_.num_tie_points);
    for (size_t turn = 0; chosen.size() < num_wanted; ++turn) {
      const size_t num_before = chosen.size();
      for (const auto& [part, ties] : parts) {
        if (turn < ties.size() && chosen.size() < num_wanted) chosen.push_back(ties[turn]);
      }
      if (chosen.size() == num_before) break;
    }
    return chosen;
  }

  static double MedianHeight(const std::vector<TiePoint>& ties) {
    std::vector<double> heights;
    heights.reserve(ties.size());
    for (const TiePoint& tie : ties) heights.push_back(tie.world_z);
    return Median(std::move(heights));
  }

  std::vector<Observation> Verified(
      const PosedImage& from,
      const PosedImage& to,
      const std::vector<TiePoint>& ties,
      const std::vector<std::optional<Eigen::Vector2d>>& followed) const {
    std::vector<size_t> kept;
    std::vector<Eigen::Vector2d> ideal_from, ideal_to;
    const double focal_px = camera_.MeanFocalPx() * to.image.scale;
    for (size_t i = 0; i < ties.size(); ++i) {
      if (!followed[i]) continue;
      kept.push_back(i);
      ideal_from.push_back(from.camera.NormalizedFromImage(ties[i].point_in_from) * focal_px);
      ideal_to.push_back(to.camera.NormalizedFromImage(*followed[i]) * focal_px);
    }
    std::vector<Observation> found;
    for (const int index : VerifyMatches(ideal_from,
                                         ideal_to,
                                         options_.max_verification_error_px,
                                         options_.min_num_tie_matches)) {
      const size_t tie = kept[static_cast<size_t>(index)];
      found.push_back({ties[tie].track_id, *followed[tie]});
    }
    return found;
  }

  const std::vector<View>& views_;
  const TrackPoints& points_;
  const Camera& camera_;
  const TracksOptions& options_;
  std::vector<TrackingImage> reduced_;
  // Known points of each view, by track.
  std::vector<std::map<int64_t, Eigen::Vector2d>> seen_;
  std::map<int64_t, size_t> num_views_of_;
};

}  // namespace

std::vector<View> FollowIntoOverlaps(std::vector<View> views,
                                     const TrackPoints& points,
                                     const Camera& camera,
                                     const ImageSource& images,
                                     const TracksOptions& options) {
  const OverlapFollower follower(views, points, camera, images, options);
  const std::vector<std::vector<size_t>> partners = follower.Partners();
  std::vector<std::vector<Observation>> found(views.size());
  cv::parallel_for_({0, static_cast<int>(views.size())}, [&](const cv::Range& range) {
    for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
      found[i] = follower.Follow(partners[i], i);
    }
  });
  for (size_t i = 0; i < views.size(); ++i) {
    views[i].observations.insert(views[i].observations.end(), found[i].begin(), found[i].end());
  }
  return views;
}

}  // namespace freelsd
