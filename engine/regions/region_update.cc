#include "engine/regions/region_update.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freelsd {
namespace {

Polygon Flat(const std::vector<Eigen::Vector3d>& corners_in_world) {
  Polygon polygon;
  for (const Eigen::Vector3d& corner : corners_in_world) polygon.push_back(corner.head<2>());
  return polygon;
}

double MeanHeight(const std::vector<Eigen::Vector3d>& corners_in_world) {
  double sum = 0.0;
  for (const Eigen::Vector3d& corner : corners_in_world) sum += corner.z();
  return sum / static_cast<double>(corners_in_world.size());
}

void SetCorners(Region& region, const std::vector<Eigen::Vector3d>& corners_in_world) {
  region.corners_in_world = corners_in_world;
  region.area_m2 = Area(Flat(corners_in_world));
}

// Rectangle around the corners of both, at their mean height.
std::vector<Eigen::Vector3d> RectangleAround(const std::vector<Eigen::Vector3d>& corners) {
  const double height = MeanHeight(corners);
  std::vector<Eigen::Vector3d> rectangle;
  for (const Eigen::Vector2d& corner : MinAreaRectangle(Flat(corners))) {
    rectangle.emplace_back(corner.x(), corner.y(), height);
  }
  return rectangle;
}

double DetectionArea(const Detection& detection) { return Area(Flat(detection.corners_in_world)); }

// Larger first; equal sizes by place, so that the order of arrival does not matter.
bool IsLarger(const Detection& a, const Detection& b) {
  const double area_a = DetectionArea(a), area_b = DetectionArea(b);
  if (area_a != area_b) return area_a > area_b;
  if (a.centroid_in_world.x() != b.centroid_in_world.x()) {
    return a.centroid_in_world.x() < b.centroid_in_world.x();
  }
  return a.centroid_in_world.y() < b.centroid_in_world.y();
}

// The region whose corners hold the centroid; of several the largest, then the oldest.
std::optional<size_t> ReDetected(const Detection& detection,
                                 const std::vector<TrackedRegion>& regions) {
  std::optional<size_t> found;
  for (size_t i = 0; i < regions.size(); ++i) {
    if (!Contains(Flat(regions[i].region.corners_in_world), detection.centroid_in_world)) continue;
    if (!found) {
      found = i;
      continue;
    }
    const Region& best = regions[*found].region;
    const Region& region = regions[i].region;
    if (region.area_m2 > best.area_m2 || (region.area_m2 == best.area_m2 && region.id < best.id)) {
      found = i;
    }
  }
  return found;
}

// All detections of one view that hit one region are one observation: grass if most area is.
void Observe(const ViewStamp& stamp,
             const std::vector<const Detection*>& detections,
             TrackedRegion& tracked) {
  double grass_area = 0.0, other_area = 0.0;
  for (const Detection* detection : detections) {
    (detection->is_grass ? grass_area : other_area) += DetectionArea(*detection);
  }
  tracked.votes[stamp.view] = grass_area > other_area;
  tracked.region.last_seen_frame_id = stamp.frame_id;
  tracked.region.last_seen_us = stamp.timestamp_us;
}

// Corners of a region that is not fixed. Detections come largest first.
void UpdateCorners(const std::vector<const Detection*>& detections, TrackedRegion& tracked) {
  std::vector<Eigen::Vector3d> corners = tracked.region.corners_in_world;
  for (const Detection* detection : detections) {
    if (detection->is_fully_visible) {
      SetCorners(tracked.region, detection->corners_in_world);
      tracked.region.is_fixed = true;
      return;
    }
    corners.insert(
        corners.end(), detection->corners_in_world.begin(), detection->corners_in_world.end());
  }
  SetCorners(tracked.region, RectangleAround(corners));
}

TrackedRegion NewRegion(const ViewStamp& stamp, const Detection& detection, int id) {
  TrackedRegion tracked;
  tracked.region.id = id;
  SetCorners(tracked.region, detection.corners_in_world);
  tracked.region.is_fixed = detection.is_fully_visible;
  tracked.region.first_seen_frame_id = stamp.frame_id;
  tracked.is_updated = true;
  Observe(stamp, {&detection}, tracked);
  return tracked;
}

bool IsSamePlace(const Region& a, const Region& b) {
  return Contains(a.Footprint(), b.Center().head<2>()) ||
         Contains(b.Footprint(), a.Center().head<2>());
}

// Corners of the larger, identity of the older, observations of both; a view counts once.
TrackedRegion Merged(const TrackedRegion& a, const TrackedRegion& b) {
  const bool is_a_larger = a.region.area_m2 > b.region.area_m2 ||
                           (a.region.area_m2 == b.region.area_m2 && a.region.id < b.region.id);
  const TrackedRegion& larger = is_a_larger ? a : b;
  const TrackedRegion& older = a.region.id < b.region.id ? a : b;
  const TrackedRegion& newest = a.region.last_seen_us >= b.region.last_seen_us ? a : b;
  TrackedRegion merged = older;
  merged.region.corners_in_world = larger.region.corners_in_world;
  merged.region.area_m2 = larger.region.area_m2;
  merged.region.is_fixed = larger.region.is_fixed;
  merged.region.last_seen_frame_id = newest.region.last_seen_frame_id;
  merged.region.last_seen_us = newest.region.last_seen_us;
  merged.votes = larger.votes;
  merged.votes.insert(a.votes.begin(), a.votes.end());
  merged.votes.insert(b.votes.begin(), b.votes.end());
  merged.is_updated = true;
  return merged;
}

// Pairs are tried largest first until none is left, so that the outcome has one order only.
void MergeRegions(std::vector<TrackedRegion>& regions) {
  bool has_merged = true;
  while (has_merged) {
    has_merged = false;
    std::sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) {
      if (a.region.area_m2 != b.region.area_m2) return a.region.area_m2 > b.region.area_m2;
      return a.region.id < b.region.id;
    });
    for (size_t i = 0; i < regions.size() && !has_merged; ++i) {
      for (size_t j = i + 1; j < regions.size() && !has_merged; ++j) {
        if (!regions[i].is_updated && !regions[j].is_updated) continue;
        if (!IsSamePlace(regions[i].region, regions[j].region)) continue;
        regions[i] = Merged(regions[i], regions[j]);
        regions.erase(regions.begin() + static_cast<std::ptrdiff_t>(j));
        has_merged = true;
      }
    }
  }
}

}  // namespace

void UpdateRegions(const ViewStamp& stamp,
                   const std::vector<Detection>& detections,
                   std::vector<TrackedRegion>& regions,
                   int& next_id) {
  for (TrackedRegion& tracked : regions) tracked.is_updated = false;
  std::vector<Detection> ordered = detections;
  std::sort(ordered.begin(), ordered.end(), IsLarger);
  std::map<size_t, std::vector<const Detection*>> hits;
  std::vector<const Detection*> unknown;
  for (const Detection& detection : ordered) {
    if (const std::optional<size_t> region = ReDetected(detection, regions)) {
      hits[*region].push_back(&detection);
    } else {
      unknown.push_back(&detection);
    }
  }
  for (const auto& [index, seen] : hits) {
    TrackedRegion& tracked = regions[index];
    Observe(stamp, seen, tracked);
    if (tracked.region.is_fixed) continue;
    UpdateCorners(seen, tracked);
    tracked.is_updated = true;
  }
  for (const Detection* detection : unknown) {
    regions.push_back(NewRegion(stamp, *detection, next_id++));
  }
  MergeRegions(regions);
}

void GradeRegions(const ViewStamp& stamp,
                  int min_num_observations,
                  const RegionsOptions& options,
                  std::vector<TrackedRegion>& regions) {
  for (TrackedRegion& tracked : regions) {
    Region& region = tracked.region;
    region.num_observations = static_cast<int>(tracked.votes.size());
    region.num_grass_observations = static_cast<int>(std::count_if(
        tracked.votes.begin(), tracked.votes.end(), [](const auto& vote) { return vote.second; }));
    const bool is_worth_a_grade =
        region.area_m2 >= options.min_area_m2 && region.num_observations >= min_num_observations;
    region.grade = is_worth_a_grade ? static_cast<double>(region.num_grass_observations) /
                                          region.num_observations
                                    : 0.0;
    if (!tracked.votes.contains(stamp.view)) continue;
    region.history.push_back({stamp.frame_id,
                              stamp.timestamp_us,
                              region.num_observations,
                              region.num_grass_observations,
                              region.grade,
                              region.area_m2});
  }
}

void KeepBest(int max_num_regions, std::vector<TrackedRegion>& regions) {
  std::sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) {
    if (a.region.grade != b.region.grade) return a.region.grade > b.region.grade;
    if (a.region.last_seen_us != b.region.last_seen_us) {
      return a.region.last_seen_us > b.region.last_seen_us;
    }
    return a.region.id < b.region.id;
  });
  if (static_cast<int>(regions.size()) > max_num_regions) {
    regions.resize(static_cast<size_t>(max_num_regions));
  }
}

}  // namespace freelsd
