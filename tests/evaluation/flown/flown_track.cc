#include "tests/evaluation/flown/flown_track.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tests/evaluation/scores/obstruction.h"

namespace freelsd {
namespace {

constexpr double kStepM = 0.2;
constexpr double kHalfSpanM = 1.0;
// A track that ends so low has touched the ground: the ground that it was flown over is coarser.
constexpr double kMaxEndHeightM = 1.0;
// Speed and direction at a place are those of this time before it.
constexpr double kDirectionS = 1.0;

GeoPoint Between(const GeoPoint& a, const GeoPoint& b, double ratio) {
  return {a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg),
          a.longitude_deg + ratio * (b.longitude_deg - a.longitude_deg),
          a.altitude_m + ratio * (b.altitude_m - a.altitude_m)};
}

// East, north from `from`.
Eigen::Vector2d Way(const GeoPoint& from, const GeoPoint& to) {
  return LocalFrame(from).WorldFromGeo(to).head<2>();
}

struct Motion {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitY();
  double speed_mps = 0.0;
};

// Up to the point of this index.
Motion MotionAt(const std::vector<TrackPoint>& points, size_t index) {
  size_t first = index;
  while (first > 0 && points[index].time_s - points[first].time_s < kDirectionS) --first;
  const Eigen::Vector2d way = Way(points[first].place, points[index].place);
  const double time_s = points[index].time_s - points[first].time_s;
  if (way.norm() < 1e-3 || time_s <= 0.0) return {};
  return {way.normalized(), way.norm() / time_s};
}

bool IsFree(const TruthMap& truth, const cv::Point& cell) {
  return truth.fault(cell) == static_cast<uint8_t>(GroundFault::kNone) ||
         NameOfFault(truth, cell) == CoverName(Cover::kDoubt);
}

}  // namespace

TrackJudge::TrackJudge(const Mosaic& mosaic, const Aircraft& aircraft)
    : mosaic_(mosaic), aircraft_(aircraft) {}

const TruthMap& TrackJudge::TruthOf(const World& world) {
  const auto found = truths_.find(&world);
  if (found != truths_.end()) return found->second;
  return truths_.emplace(&world, MakeTruthMap(world, aircraft_)).first->second;
}

TrackJudge::Contact TrackJudge::ContactAt(const MosaicPlace& place) {
  const TruthMap& truth = TruthOf(*place.world);
  const Eigen::Vector2d at = place.in_world.head<2>();
  const cv::Point cell = truth.CellAt(at);
  const std::string thing = NameOfThing(*place.world, at, ThinThings::kCount);
  if (thing == "wire") return {false, thing, true};
  if (IsFree(truth, cell)) return {true, "", false};
  return {false,
          thing == "ground" ? NameOfFault(truth, cell) : thing,
          IsThinName(thing) || IsThinFault(truth, cell)};
}

std::optional<TrackJudge::Contact> TrackJudge::FirstContact(const GeoPoint& place,
                                                            const Eigen::Vector2d& direction) {
  const Eigen::Vector2d left(-direction.y(), direction.x());
  MosaicPlace middle = mosaic_.PlaceOf(place);
  for (const double across : {-kHalfSpanM, kHalfSpanM}) {
    MosaicPlace wing = middle;
    wing.in_world.head<2>() += across * left;
    if (wing.HeightAbove() > 0.0) continue;
    Contact contact = ContactAt(wing);
    if (!contact.is_free) return contact;
  }
  if (middle.HeightAbove() > 0.0) return std::nullopt;
  return ContactAt(middle);
}

TrackVerdict TrackJudge::Judge(const FlownTrack& track) {
  if (track.points.size() < 2) throw std::invalid_argument("track " + track.id + ": too short");
  TrackVerdict verdict;
  const auto end = [&](size_t index, const GeoPoint& place, const Contact& contact) {
    const TrackPoint& next = track.points[index];
    const Motion motion = MotionAt(track.points, index);
    verdict.has_contact = true;
    verdict.hit = contact.name;
    verdict.is_thin = contact.is_thin;
    verdict.time_s = next.time_s;
    verdict.place = place;
    const Eigen::Vector2d offset = Way(track.touchdown, place);
    const Eigen::Vector2d forward = DirectionOf(track.heading);
    verdict.along_m = offset.dot(forward);
    verdict.across_m = offset.dot(Eigen::Vector2d(-forward.y(), forward.x()));
    verdict.is_in_disc = offset.norm() <= track.touchdown_uncertainty_m;
    verdict.ground_speed_mps = motion.speed_mps;
    if (contact.is_free) JudgeRoll(track, motion.direction, verdict);
  };
  for (size_t i = 1; i < track.points.size(); ++i) {
    const GeoPoint& from = track.points[i - 1].place;
    const GeoPoint& to = track.points[i].place;
    const Eigen::Vector2d direction = MotionAt(track.points, i).direction;
    const int num_steps = std::max(1, static_cast<int>(std::ceil(Way(from, to).norm() / kStepM)));
    for (int k = 1; k <= num_steps; ++k) {
      const GeoPoint place = Between(from, to, static_cast<double>(k) / num_steps);
      const auto contact = FirstContact(place, direction);
      if (!contact) continue;
      end(i, place, *contact);
      return verdict;
    }
  }
  const MosaicPlace last = mosaic_.PlaceOf(track.points.back().place);
  verdict.time_s = track.points.back().time_s;
  verdict.place = track.points.back().place;
  if (last.HeightAbove() < kMaxEndHeightM) {
    end(track.points.size() - 1, track.points.back().place, ContactAt(last));
  }
  return verdict;
}

// Cells whose centre lies on the strip ahead, as wide as the planner keeps free.
void TrackJudge::JudgeRoll(const FlownTrack& track,
                           const Eigen::Vector2d& direction,
                           TrackVerdict& verdict) {
  const double flown_m = Way(verdict.place, track.points.back().place).dot(direction);
  verdict.roll_m = std::max(aircraft_.ground_roll_m, flown_m);
  const MosaicPlace begin = mosaic_.PlaceOf(verdict.place);
  const TruthMap& truth = TruthOf(*begin.world);
  const Eigen::Vector2d left(-direction.y(), direction.x());
  const double step_m = 0.5 * truth.cell_size_m;
  for (double along = 0.0; along <= verdict.roll_m; along += step_m) {
    for (double across = -aircraft_.path_half_width_m; across <= aircraft_.path_half_width_m;
         across += step_m) {
      const Eigen::Vector2d at = begin.in_world.head<2>() + along * direction + across * left;
      const cv::Point cell = truth.CellAt(at);
      if (IsFree(truth, cell)) continue;
      const Eigen::Vector2d center = truth.CellCenter(cell.y, cell.x) - begin.in_world.head<2>();
      if (std::abs(center.dot(left)) > aircraft_.path_half_width_m) continue;
      verdict.roll_fault = NameOfFault(truth, cell);
      verdict.is_thin = IsThinFault(truth, cell);
      return;
    }
  }
}

}  // namespace freelsd
