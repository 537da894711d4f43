#include "server/recall/live_pose/course.h"

#include <cmath>
#include <cstdlib>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Positions of a GNSS receiver within a few seconds have a noise of a few metres. Over this
// distance, the error of the course is about 10 degrees.
constexpr double kMinWayM = 20.0;
// In a turn, the measured course is that at the middle of the way. It is late by at most half the
// way, which costs a few metres of height.
constexpr double kMaxSpanS = 4.0;
// A link may deliver samples in bursts. Older samples may be from before a restart of the
// autopilot. After the restart, its clock may show the same times again.
constexpr double kMaxArrivalSpanS = 10.0;
// A greater speed is an error of the receiver.
constexpr double kMaxSpeedMps = 150.0;
// Largest ratio of the way through the middle position to the direct way. A larger ratio is a
// circle, or an error of the receiver.
constexpr double kMaxDetourRatio = 1.2;

double SecondsBetween(int64_t earlier_us, int64_t later_us) {
  return (static_cast<double>(later_us) - static_cast<double>(earlier_us)) * 1e-6;
}

Eigen::Vector2d Way(const PassedPosition& from, const PassedPosition& to) {
  return LocalFrame(from.place).WorldFromGeo(to.place).head<2>();
}

// The position nearest to the middle in time, without the first and the last position.
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

// The latest positions, from which the course is computed. They are in order of time, and as few as
// possible. Empty if no three positions are far enough apart.
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
