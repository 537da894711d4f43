#include "server/recall/course.h"

#include <cmath>
#include <cstdlib>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Between positions that a GNSS receiver gives within seconds, a few metres are noise: the course
// over this way is known to about 10 degrees.
constexpr double kMinWayM = 20.0;
// In a turn, the course over a way is that of its middle. So it is late by half the way at most,
// which costs a few metres of height.
constexpr double kMaxSpanS = 4.0;
// A link may deliver samples in bursts. Samples from farther back may be of another start of the
// autopilot, whose clock began at the same time again.
constexpr double kMaxArrivalSpanS = 10.0;
// What is faster is a jump of the receiver, not a small aircraft.
constexpr double kMaxSpeedMps = 150.0;
// A way by the position in its middle may be so much longer. More is a circle, or a jump.
constexpr double kMaxDetourRatio = 1.2;

double SecondsBetween(int64_t earlier_us, int64_t later_us) {
  return (static_cast<double>(later_us) - static_cast<double>(earlier_us)) * 1e-6;
}

Eigen::Vector2d Way(const PassedPosition& from, const PassedPosition& to) {
  return LocalFrame(from.place).WorldFromGeo(to.place).head<2>();
}

// Of the positions between the first and the last, the one nearest to the middle in time.
const PassedPosition& MiddleOf(const std::vector<PassedPosition>& latest_first) {
  const double whole_s =
      SecondsBetween(latest_first.back().timestamp_us, latest_first.front().timestamp_us);
  const PassedPosition* middle = &latest_first[1];
  double least_s = whole_s;
  for (size_t i = 1; i + 1 < latest_first.size(); ++i) {
    const double to_end_s =
        SecondsBetween(latest_first[i].timestamp_us, latest_first.front().timestamp_us);
    const double off_s = std::abs(to_end_s - 0.5 * whole_s);
    if (off_s >= least_s) continue;
    least_s = off_s;
    middle = &latest_first[i];
  }
  return *middle;
}

// The end of the list that the course is taken from: in order of time, and as short as may be.
// Empty if no three positions reach far enough.
std::vector<PassedPosition> LastWay(const std::vector<PassedPosition>& passed) {
  if (passed.empty()) return {};
  const PassedPosition& latest = passed.front();
  std::vector<PassedPosition> way{latest};
  for (const PassedPosition& each : passed) {
    if (SecondsBetween(each.arrived_at_us, latest.arrived_at_us) > kMaxArrivalSpanS) break;
    const double span_s = SecondsBetween(each.timestamp_us, latest.timestamp_us);
    if (each.timestamp_us >= way.back().timestamp_us || span_s > kMaxSpanS) continue;
    way.push_back(each);
    if (way.size() >= 3 && Way(each, latest).norm() >= kMinWayM) return way;
  }
  return {};
}

}  // namespace

std::optional<double> CourseDeg(const std::vector<PassedPosition>& passed) {
  const std::vector<PassedPosition> last = LastWay(passed);
  if (last.empty()) return std::nullopt;
  const Eigen::Vector2d way = Way(last.back(), last.front());
  const double span_s = SecondsBetween(last.back().timestamp_us, last.front().timestamp_us);
  if (way.norm() > kMaxSpeedMps * span_s) return std::nullopt;
  const PassedPosition& middle = MiddleOf(last);
  const double detour_m = Way(last.back(), middle).norm() + Way(middle, last.front()).norm();
  if (detour_m > kMaxDetourRatio * way.norm()) return std::nullopt;
  return std::fmod(DegFromRad(HeadingOf(way)) + 360.0, 360.0);
}

}  // namespace freelsd
