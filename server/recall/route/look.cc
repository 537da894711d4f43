#include "server/recall/route/look.h"

#include <algorithm>
#include <cmath>

#include "server/recall/recall_candidates.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {
namespace {

// Places and moments looked at to choose a place.
constexpr size_t kMaxNumPlaces = 16;
constexpr size_t kMaxNumMoments = 24;
constexpr int kNumDirections = 8;
// Sites within this distance tell how high the ground may be.
constexpr double kSurroundingsM = 10000.0;
// A strip that helps for less than half of the gap, and for less than this time, is not worth it.
constexpr double kLeastHelpS = 20.0;

// At most `num` of [first, last], evenly.
std::vector<size_t> Some(size_t first, size_t last, size_t num) {
  const size_t size = last - first + 1;
  std::vector<size_t> some;
  for (size_t i = 0; i < std::min(size, num); ++i) {
    some.push_back(first + (2 * i + 1) * size / (2 * std::min(size, num)));
  }
  return some;
}

// In the request's datum.
std::optional<double> HighestSiteNear(const StoredSites& stored, const EmergencyRequest& request) {
  const auto rows = stored.storage.sites.ListRecallable(BoxAround(request.place, kSurroundingsM));
  std::optional<double> highest_m;
  GlidingFleet fleet;
  for (const RecallCandidate& candidate : Candidates(request, rows, fleet)) {
    const double altitude_m = candidate.row->data.altitude_m + candidate.datum.subtracted_m;
    highest_m = std::max(highest_m.value_or(altitude_m), altitude_m);
  }
  return highest_m;
}

bool IsSeen(const StoredSites& stored, const GeoPoint& place) {
  for (const auto& row : stored.storage.sites.ListMaps(BoxAround(place, 0.0))) {
    const auto terrain = stored.maps.TerrainOf(stored.storage, row->id);
    if (!terrain || !terrain->CountsFor(std::nullopt)) continue;
    const Eigen::Vector3d in_world = LocalFrame(terrain->origin).WorldFromGeo(place);
    if (IsSeenBelow(*terrain, in_world, in_world)) return true;
  }
  return false;
}

// A strip that may exist.
class PossibleStrip {
 public:
  PossibleStrip(const GeoPoint& place, const Aircraft& unpowered)
      : local_frame_(place), aircraft_(unpowered) {}

  bool IsReached(const EmergencyRequest& request) const {
    const GlideStart start = StartOf(request, local_frame_.WorldFromGeo(request.place));
    const double final_m =
        aircraft_.approach_height_m / std::tan(RadFromDeg(aircraft_.flight_path_angle_deg));
    for (int i = 0; i < kNumDirections; ++i) {
      const double heading = 2.0 * kPi * i / kNumDirections;
      const Eigen::Vector3d final_start(
          -std::sin(heading) * final_m, -std::cos(heading) * final_m, aircraft_.approach_height_m);
      const auto glide = GlideTo(start, final_start, heading, aircraft_, {});
      if (!glide || glide->arrival_height_m < final_start.z() + request.arrival_height_m) {
        return false;
      }
    }
    return true;
  }

 private:
  LocalFrame local_frame_;
  Aircraft aircraft_;
};

bool IsReachedInAllWinds(const PossibleStrip& strip,
                         const RouteJudge& judge,
                         const RouteRequest& request,
                         const RouteMoment& moment) {
  if (request.winds.empty()) return strip.IsReached(judge.RequestAt(moment, std::nullopt));
  return std::all_of(request.winds.begin(), request.winds.end(), [&](const WeightedWind& wind) {
    return strip.IsReached(judge.RequestAt(moment, wind.wind_in_world));
  });
}

}  // namespace

std::optional<RouteFix> LookFirst(const RouteJudge& judge,
                                  const StoredSites& stored,
                                  const RouteRequest& request,
                                  const Insurance& insurance,
                                  size_t gap) {
  const RouteGap& closed = insurance.gaps[gap];
  const auto moment_at = [&](size_t i) { return insurance.moments[i].moment; };
  const size_t middle = (closed.first + closed.last) / 2;
  const EmergencyRequest from_middle = judge.RequestAt(moment_at(middle), std::nullopt);
  const auto altitude_m = HighestSiteNear(stored, from_middle);
  if (!altitude_m) return std::nullopt;
  const Aircraft aircraft =
      LeastGlidingAircraft(from_middle, stored.storage.sites.BoundsOfRecallable());
  const auto num_reached = [&](const GeoPoint& place, const std::vector<size_t>& moments) {
    const PossibleStrip strip(place, aircraft);
    return std::count_if(moments.begin(), moments.end(), [&](size_t i) {
      return IsReachedInAllWinds(strip, judge, request, moment_at(i));
    });
  };
  std::optional<GeoPoint> best;
  std::ptrdiff_t most = 0;
  for (const size_t below : Some(closed.first, closed.last, kMaxNumPlaces)) {
    GeoPoint place = moment_at(below).place;
    place.altitude_m = *altitude_m;
    if (IsSeen(stored, place)) continue;
    const auto num = num_reached(place, Some(closed.first, closed.last, kMaxNumMoments));
    if (num <= most) continue;
    most = num;
    best = place;
  }
  if (!best) return std::nullopt;
  const size_t size = closed.last - closed.first + 1;
  const auto closed_by_it =
      static_cast<double>(num_reached(*best, Some(closed.first, closed.last, size)));
  const double period_s = judge.options().moment_period_s;
  if (closed_by_it < 0.5 * static_cast<double>(size) && closed_by_it * period_s < kLeastHelpS) {
    return std::nullopt;
  }
  RouteFix fix;
  fix.kind = FixKind::kLook;
  fix.gap = gap;
  fix.place = best;
  fix.gaps_left_s = (static_cast<double>(insurance.NumUncovered()) - closed_by_it) * period_s;
  return fix;
}

}  // namespace freelsd
