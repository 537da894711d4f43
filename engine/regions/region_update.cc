#include "engine/regions/region_update.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace freelsd {
namespace {

bool ContainsPlace(const Region& region, const Eigen::Vector3d& place_in_world) {
  return Contains(region.Footprint(), place_in_world.head<2>());
}

// Sorts by content, so that the order of segments does not matter.
void SortByContent(std::vector<Detection>& detections) {
  const auto key = [](const Detection& detection) {
    return std::tuple(-Area(GroundPolygon(detection.corners_in_world)),
                      detection.centroid_in_world.x(),
                      detection.centroid_in_world.y(),
                      -detection.area_m2,
                      detection.is_grass);
  };
  std::sort(detections.begin(), detections.end(), [&](const auto& a, const auto& b) {
    return key(a) < key(b);
  });
}

// Unlike surfaces are one place only if they cover the same ground.
bool AreCompatible(bool is_a_grass,
                   const Polygon& a,
                   bool is_b_grass,
                   const Polygon& b,
                   const RegionsOptions& options) {
  return is_a_grass == is_b_grass || OverlapRatio(a, b) >= options.min_overlap_of_unlike_ratio;
}

// The region whose corners contain the centroid; of several, the one with the nearest centre.
std::optional<size_t> RedetectedRegion(const std::vector<TrackedRegion>& tracked,
                                       const Detection& detection,
                                       const RegionsOptions& options) {
  const Polygon ground = GroundPolygon(detection.corners_in_world);
  std::optional<size_t> nearest;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < tracked.size(); ++i) {
    if (!ContainsPlace(tracked[i].region, detection.centroid_in_world)) continue;
    if (!AreCompatible(tracked[i].IsGrass(),
                       tracked[i].region.Footprint(),
                       detection.is_grass,
                       ground,
                       options)) {
      continue;
    }
    const double distance =
        (tracked[i].region.Center() - detection.centroid_in_world).head<2>().norm();
    if (distance >= nearest_distance) continue;
    nearest = i;
    nearest_distance = distance;
  }
  return nearest;
}

// Rectangle around all corners. Each new corner takes the height of the nearest old corner.
std::vector<Eigen::Vector3d> RectangleAround(const std::vector<Eigen::Vector3d>& corners) {
  std::vector<Eigen::Vector3d> rectangle;
  for (const Eigen::Vector2d& vertex : MinAreaRectangle(GroundPolygon(corners))) {
    const auto nearest =
        std::min_element(corners.begin(), corners.end(), [&](const auto& a, const auto& b) {
          return (a.template head<2>() - vertex).squaredNorm() <
                 (b.template head<2>() - vertex).squaredNorm();
        });
    rectangle.emplace_back(vertex.x(), vertex.y(), nearest->z());
  }
  return rectangle;
}

void SetCorners(TrackedRegion& tracked, std::vector<Eigen::Vector3d> corners_in_world) {
  tracked.region.corners_in_world = std::move(corners_in_world);
  tracked.region.area_m2 = Area(tracked.region.Footprint());
  tracked.has_new_corners = true;
}

// Whether the detection shows the whole region, not a patch. Rectangles, counter-clockwise.
bool ShowsAllOf(const Region& region, const Detection& detection, double min_share) {
  if (!detection.is_fully_visible) return false;
  const Polygon known = region.Footprint();
  const Polygon common = ConvexIntersection(known, GroundPolygon(detection.corners_in_world));
  return Area(common) >= min_share * Area(known);
}

// Sec. III-E1: fixed corners stay. The first full view fixes them. Until then they grow.
void UpdateCorners(TrackedRegion& tracked,
                   const std::vector<const Detection*>& detections,
                   const RegionsOptions& options) {
  if (tracked.region.is_fixed || detections.empty()) return;
  std::vector<Eigen::Vector3d> corners = tracked.region.corners_in_world;
  for (const Detection* detection : detections) {
    // The largest one, because detections are sorted.
    if (ShowsAllOf(tracked.region, *detection, options.min_fixing_overlap_ratio)) {
      tracked.region.is_fixed = true;
      SetCorners(tracked, detection->corners_in_world);
      return;
    }
    corners.insert(
        corners.end(), detection->corners_in_world.begin(), detection->corners_in_world.end());
  }
  SetCorners(tracked, RectangleAround(corners));
}

void Observe(TrackedRegion& tracked, const ViewStamp& stamp, const Detection& detection) {
  ViewEvidence& evidence = tracked.evidence[stamp.view];
  (detection.is_grass ? evidence.grass_area_m2 : evidence.other_area_m2) += detection.area_m2;
  tracked.region.last_seen_frame_id = stamp.frame_id;
  tracked.region.last_seen_us = stamp.timestamp_us;
}

TrackedRegion NewRegion(int id, const ViewStamp& stamp, const Detection& detection) {
  TrackedRegion tracked;
  tracked.region.id = id;
  tracked.region.is_fixed = detection.is_fully_visible;
  tracked.region.first_seen_frame_id = stamp.frame_id;
  SetCorners(tracked, detection.corners_in_world);
  Observe(tracked, stamp, detection);
  return tracked;
}

bool BelongTogether(const TrackedRegion& a, const TrackedRegion& b, const RegionsOptions& options) {
  if (!a.has_new_corners && !b.has_new_corners) return false;
  if (!AreCompatible(
          a.IsGrass(), a.region.Footprint(), b.IsGrass(), b.region.Footprint(), options)) {
    return false;
  }
  return ContainsPlace(a.region, b.region.Center()) || ContainsPlace(b.region, a.region.Center());
}

// Keeps the older id, the larger corners and the evidence of both.
TrackedRegion Merged(const TrackedRegion& older, const TrackedRegion& younger) {
  TrackedRegion merged = older;
  merged.has_new_corners = true;
  if (younger.region.area_m2 > older.region.area_m2) {
    merged.region.corners_in_world = younger.region.corners_in_world;
    merged.region.area_m2 = younger.region.area_m2;
    merged.region.is_fixed = younger.region.is_fixed;
  }
  for (const auto& [view, evidence] : younger.evidence) {
    merged.evidence[view].grass_area_m2 += evidence.grass_area_m2;
    merged.evidence[view].other_area_m2 += evidence.other_area_m2;
  }
  if (younger.evidence.rbegin()->first > older.evidence.rbegin()->first) {
    merged.region.last_seen_frame_id = younger.region.last_seen_frame_id;
    merged.region.last_seen_us = younger.region.last_seen_us;
  }
  return merged;
}

size_t LastView(const TrackedRegion& tracked) { return tracked.evidence.rbegin()->first; }

size_t Root(const std::vector<size_t>& parent, size_t i) {
  while (parent[i] != i) i = parent[i];
  return i;
}

}  // namespace

bool TrackedRegion::IsGrass() const {
  const auto num_grass = std::count_if(evidence.begin(), evidence.end(), [](const auto& entry) {
    return entry.second.grass_area_m2 > entry.second.other_area_m2;
  });
  return 2 * num_grass > static_cast<std::ptrdiff_t>(evidence.size());
}

void RegionTracker::Update(const ViewStamp& stamp,
                           std::vector<Detection> detections,
                           int min_num_observations) {
  SortByContent(detections);
  for (TrackedRegion& tracked : tracked_) tracked.has_new_corners = false;
  Assign(stamp, detections);
  while (MergeOnce()) {
  }
  Grade(stamp, min_num_observations);
  DropWorst(min_num_observations);
}

// Compares all detections with the regions as they were before this view.
void RegionTracker::Assign(const ViewStamp& stamp, const std::vector<Detection>& detections) {
  std::vector<std::vector<const Detection*>> detections_of(tracked_.size());
  std::vector<TrackedRegion> added;
  for (const Detection& detection : detections) {
    if (const std::optional<size_t> i = RedetectedRegion(tracked_, detection, options_)) {
      detections_of[*i].push_back(&detection);
      Observe(tracked_[*i], stamp, detection);
    } else {
      added.push_back(NewRegion(next_id_++, stamp, detection));
    }
  }
  for (size_t i = 0; i < detections_of.size(); ++i) {
    UpdateCorners(tracked_[i], detections_of[i], options_);
  }
  for (TrackedRegion& tracked : added) tracked_.push_back(std::move(tracked));
}

// Sec. III-E2. Joins each connected set at once, so that order does not matter; true if any.
bool RegionTracker::MergeOnce() {
  std::vector<size_t> parent(tracked_.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  for (size_t i = 0; i < tracked_.size(); ++i) {
    for (size_t j = i + 1; j < tracked_.size(); ++j) {
      if (!BelongTogether(tracked_[i], tracked_[j], options_)) continue;
      const size_t a = Root(parent, i), b = Root(parent, j);
      parent[std::max(a, b)] = std::min(a, b);  // the oldest is the root
    }
  }
  std::vector<TrackedRegion> merged;
  std::map<size_t, size_t> place_of_root;
  for (size_t i = 0; i < tracked_.size(); ++i) {
    const auto [place, is_new] = place_of_root.emplace(Root(parent, i), merged.size());
    if (is_new) {
      merged.push_back(tracked_[i]);
    } else {
      merged[place->second] = Merged(merged[place->second], tracked_[i]);
    }
  }
  const bool has_merged = merged.size() < tracked_.size();
  tracked_ = std::move(merged);
  return has_merged;
}

// Sec. III-E3.
void RegionTracker::Grade(const ViewStamp& stamp, int min_num_observations) {
  for (TrackedRegion& tracked : tracked_) {
    Region& region = tracked.region;
    region.num_observations = static_cast<int>(tracked.evidence.size());
    region.num_grass_observations = static_cast<int>(
        std::count_if(tracked.evidence.begin(), tracked.evidence.end(), [](const auto& entry) {
          return entry.second.grass_area_m2 > entry.second.other_area_m2;
        }));
    const bool has_grade =
        region.area_m2 >= options_.min_area_m2 && region.num_observations >= min_num_observations;
    region.grade =
        has_grade ? static_cast<double>(region.num_grass_observations) / region.num_observations
                  : 0.0;
    if (!tracked.evidence.contains(stamp.view)) continue;
    region.history.push_back({.frame_id = stamp.frame_id,
                              .timestamp_us = stamp.timestamp_us,
                              .num_observations = region.num_observations,
                              .num_grass_observations = region.num_grass_observations,
                              .grade = region.grade,
                              .area_m2 = region.area_m2});
  }
}

// Keeps the best regions and as many young ones without a grade. Otherwise twenty graded regions
// would block every new one.
void RegionTracker::DropWorst(int min_num_observations) {
  const auto limit = static_cast<size_t>(options_.max_num_regions);
  std::vector<TrackedRegion> graded, young;
  for (TrackedRegion& tracked : tracked_) {
    const bool is_young = tracked.region.num_observations < min_num_observations;
    (is_young ? young : graded).push_back(std::move(tracked));
  }
  const auto key = [](const TrackedRegion& tracked) {
    return std::tuple(-tracked.region.grade,
                      std::numeric_limits<size_t>::max() - LastView(tracked),
                      -tracked.region.num_observations,
                      -tracked.region.area_m2,
                      tracked.region.id);
  };
  const auto is_better = [&](const auto& a, const auto& b) { return key(a) < key(b); };
  const auto by_id = [](const auto& a, const auto& b) { return a.region.id < b.region.id; };
  tracked_.clear();
  for (std::vector<TrackedRegion>* kind : {&graded, &young}) {
    std::sort(kind->begin(), kind->end(), is_better);
    if (kind->size() > limit) kind->erase(kind->begin() + limit, kind->end());
    std::move(kind->begin(), kind->end(), std::back_inserter(tracked_));
  }
  std::sort(tracked_.begin(), tracked_.end(), by_id);
}

std::vector<Region> RegionTracker::Ranked() const {
  std::vector<Region> ranked;
  for (const TrackedRegion& tracked : tracked_) ranked.push_back(tracked.region);
  std::sort(ranked.begin(), ranked.end(), [](const Region& a, const Region& b) {
    return std::tuple(-a.grade, -a.num_observations, a.id) <
           std::tuple(-b.grade, -b.num_observations, b.id);
  });
  if (ranked.size() > static_cast<size_t>(options_.max_num_regions)) {
    ranked.erase(ranked.begin() + options_.max_num_regions, ranked.end());
  }
  return ranked;
}

}  // namespace freelsd
