#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "server/recall/obstacles/obstacles.h"

namespace freelsd {
namespace {

// Legs are split, because a line that is straight in degrees is not straight in a map's plane.
constexpr double kMaxPieceM = 500.0;
// More than half the diagonal of any cell, and than a wingspan.
constexpr double kLeastReachM = 20.0;

BoundingBox Grown(const BoundingBox& box, double reach_m) {
  const double dlat_deg = reach_m / kMetresPerDegree;
  const double far_deg = std::max(std::abs(box.south_deg), std::abs(box.north_deg)) + dlat_deg;
  const double shrink = std::max(0.01, std::cos(RadFromDeg(std::min(far_deg, 89.5))));
  const double dlon_deg = dlat_deg / shrink;
  return {box.west_deg - dlon_deg,
          box.south_deg - dlat_deg,
          box.east_deg + dlon_deg,
          box.north_deg + dlat_deg};
}

// Both may leave [-180, 180].
bool MeetsAlongParallel(double west_a, double east_a, double west_b, double east_b) {
  if (east_a < west_a) east_a += 360.0;
  if (east_b < west_b) east_b += 360.0;
  for (const double turn : {-360.0, 0.0, 360.0}) {
    if (west_a + turn <= east_b && east_a + turn >= west_b) return true;
  }
  return false;
}

bool MeetsBox(const BoundingBox& a, const BoundingBox& b) {
  return a.south_deg <= b.north_deg && a.north_deg >= b.south_deg &&
         MeetsAlongParallel(a.west_deg, a.east_deg, b.west_deg, b.east_deg);
}

std::shared_ptr<const KnownObstacle> Known(const ObstacleRow& row) {
  auto known = std::make_shared<KnownObstacle>();
  try {
    known->given = ParseStoredObstacle(nlohmann::json::parse(row.feature_json));
  } catch (const std::exception& error) {
    // What cannot be read must not be left out: it may be a wire.
    throw StorageError("read the obstacle " + row.id, error.what());
  }
  known->given.id = row.id;
  known->updated_at_us = row.updated_at_us;
  const double reach_m =
      ObstacleOptions{}.position_sigma * known->given.position_sd_m + kLeastReachM;
  known->box = Grown(row.box, reach_m);
  return known;
}

bool IsInForce(const KnownObstacle& obstacle, int64_t now_us) {
  return !obstacle.given.expires_at_us || *obstacle.given.expires_at_us > now_us;
}

// The leg from `a`, in pieces, without its end.
void AddLeg(const GeoPoint& a, const GeoPoint& b, std::vector<GeoPoint>& points) {
  const double dlat_m = (b.latitude_deg - a.latitude_deg) * kMetresPerDegree;
  const double dlon_m = (b.longitude_deg - a.longitude_deg) * kMetresPerDegree *
                        std::cos(RadFromDeg(0.5 * (a.latitude_deg + b.latitude_deg)));
  const int num_pieces =
      std::max(1, static_cast<int>(std::ceil(std::hypot(dlat_m, dlon_m) / kMaxPieceM)));
  for (int i = 0; i < num_pieces; ++i) {
    const double ratio = static_cast<double>(i) / num_pieces;
    points.push_back({a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg),
                      a.longitude_deg + ratio * (b.longitude_deg - a.longitude_deg),
                      a.altitude_m + ratio * (b.altitude_m - a.altitude_m)});
  }
}

std::vector<GeoPoint> InPieces(const GivenObstacle& given) {
  std::vector<GeoPoint> points;
  for (size_t i = 1; i < given.points.size(); ++i) {
    AddLeg(given.points[i - 1], given.points[i], points);
  }
  if (given.is_area) {
    AddLeg(given.points.back(), given.points.front(), points);
  } else {
    points.push_back(given.points.back());
  }
  return points;
}

Eigen::Vector3d TopInWorld(const GivenObstacle& given,
                           const GeoPoint& point,
                           const LocalFrame& local_frame,
                           const AltitudeReference& map) {
  const bool is_known = !std::isnan(point.altitude_m);
  const double altitude_m =
      is_known ? AltitudeIn(given, point.altitude_m, map) : local_frame.origin().altitude_m;
  Eigen::Vector3d top =
      local_frame.WorldFromGeo({point.latitude_deg, point.longitude_deg, altitude_m});
  if (!is_known) top.z() = std::numeric_limits<double>::quiet_NaN();
  return top;
}

HardObstacle WithoutPoints(const GivenObstacle& given) {
  HardObstacle made;
  made.id = given.id;
  made.shape = given.is_area ? HardObstacle::Shape::kArea : HardObstacle::Shape::kLine;
  made.height_above_ground = given.kind == ObstacleKind::kPeople
                                 ? std::optional(ObstacleOptions{}.people_height_m)
                                 : given.height_m;
  made.position_sd_m = given.position_sd_m;
  return made;
}

// A line may leave and enter the surroundings of the origin several times.
void AddInWorld(const GivenObstacle& given,
                const LocalFrame& local_frame,
                const AltitudeReference& map,
                double far_m,
                std::vector<HardObstacle>& made) {
  HardObstacle run = WithoutPoints(given);
  for (const GeoPoint& point : InPieces(given)) {
    const Eigen::Vector3d top = TopInWorld(given, point, local_frame, map);
    if (given.is_area || top.head<2>().norm() <= far_m) {
      run.points_in_world.push_back(top);
      continue;
    }
    if (!run.points_in_world.empty()) made.push_back(run);
    run.points_in_world.clear();
  }
  if (!run.points_in_world.empty()) made.push_back(std::move(run));
}

}  // namespace

BoundingBox BoxOfPoints(const std::vector<GeoPoint>& points) {
  BoundingBox box{180.0, 90.0, -180.0, -90.0};
  for (const GeoPoint& point : points) {
    box = {std::min(box.west_deg, point.longitude_deg),
           std::min(box.south_deg, point.latitude_deg),
           std::max(box.east_deg, point.longitude_deg),
           std::max(box.north_deg, point.latitude_deg)};
  }
  return box;
}

BoundingBox BoxAroundPlace(const GeoPoint& place, double reach_m) {
  return Grown({place.longitude_deg, place.latitude_deg, place.longitude_deg, place.latitude_deg},
               reach_m);
}

std::shared_ptr<const ObstacleCache::List> ObstacleCache::Current(const Storage& storage) {
  const uint64_t version = storage.obstacles.Version();
  {
    const std::lock_guard lock(mutex_);
    if (list_ && list_->version == version) return list_;
  }
  auto list = std::make_shared<List>();
  list->version = version;
  for (const ObstacleRow& row : storage.obstacles.List()) {
    list->from_south.push_back(Known(row));
    const BoundingBox& box = list->from_south.back()->box;
    list->tallest_deg = std::max(list->tallest_deg, box.north_deg - box.south_deg);
  }
  std::stable_sort(
      list->from_south.begin(), list->from_south.end(), [](const auto& a, const auto& b) {
        return a->box.south_deg < b->box.south_deg;
      });
  const std::lock_guard lock(mutex_);
  // Another thread may have read a later version in the meantime.
  if (!list_ || list_->version <= version) list_ = list;
  return list;
}

KnownObstacles ObstacleCache::Near(const Storage& storage, const BoundingBox& box, int64_t now_us) {
  const std::shared_ptr<const List> list = Current(storage);
  const auto& rows = list->from_south;
  const auto first = std::partition_point(rows.begin(), rows.end(), [&](const auto& each) {
    return each->box.south_deg + list->tallest_deg < box.south_deg;
  });
  KnownObstacles near;
  for (auto each = first; each != rows.end() && (*each)->box.south_deg <= box.north_deg; ++each) {
    if (MeetsBox((*each)->box, box) && IsInForce(**each, now_us)) near.push_back(*each);
  }
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return a->given.id < b->given.id;
  });
  return near;
}

std::optional<int64_t> ObstacleCache::NextExpiryUs(const Storage& storage, int64_t now_us) {
  const std::shared_ptr<const List> list = Current(storage);
  std::optional<int64_t> next_us;
  for (const auto& each : list->from_south) {
    const std::optional<int64_t>& expires_at_us = each->given.expires_at_us;
    if (!expires_at_us || *expires_at_us <= now_us) continue;
    next_us = std::min(next_us.value_or(*expires_at_us), *expires_at_us);
  }
  return next_us;
}

std::string KeyOf(const KnownObstacles& obstacles) {
  std::string key;
  for (const auto& each : obstacles) {
    if (!each->IsHard()) continue;
    key.append(each->given.id).append("@").append(std::to_string(each->updated_at_us)).append(";");
  }
  return key;
}

double AltitudeIn(const GivenObstacle& obstacle,
                  double altitude_m,
                  const AltitudeReference& stored) {
  const GeoPoint& place = obstacle.points.front();
  const DatumDifference difference = DatumDifferenceOf(
      {obstacle.altitude_datum, place.latitude_deg, place.longitude_deg, {}}, stored);
  const bool is_exact =
      difference.basis == DatumBasis::kSame || difference.basis == DatumBasis::kGeoid;
  return is_exact ? altitude_m - difference.subtracted_m
                  : altitude_m + std::abs(difference.subtracted_m);
}

std::vector<HardObstacle> InWorld(const KnownObstacles& obstacles,
                                  const LocalFrame& local_frame,
                                  const AltitudeReference& map,
                                  double far_m) {
  std::vector<HardObstacle> made;
  for (const auto& each : obstacles) {
    if (each->IsHard()) AddInWorld(each->given, local_frame, map, far_m, made);
  }
  return made;
}

}  // namespace freelsd
