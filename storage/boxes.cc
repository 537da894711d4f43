#include "storage/boxes.h"

#include <cmath>

namespace freelsd {
namespace {

constexpr double kTurnDeg = 360.0;
// Farther than any longitude of an unrolled box.
constexpr double kAnyDeg = 1000.0;

double WrappedDeg(double longitude_deg) { return std::remainder(longitude_deg, kTurnDeg); }

}  // namespace

std::vector<BoundingBox> PlainBoxes(const BoundingBox& box) {
  const bool is_round = box.east_deg - box.west_deg >= kTurnDeg;
  const double west_deg = is_round ? -180.0 : WrappedDeg(box.west_deg);
  const double east_deg = is_round ? 180.0 : WrappedDeg(box.east_deg);
  if (west_deg <= east_deg) return {{west_deg, box.south_deg, east_deg, box.north_deg}};
  return {{west_deg, box.south_deg, 180.0, box.north_deg},
          {-180.0, box.south_deg, east_deg, box.north_deg}};
}

std::vector<BoundingBox> TouchingBoxes(const BoundingBox& box) {
  std::vector<BoundingBox> boxes = PlainBoxes(box);
  const bool touches_from_east = boxes.front().west_deg == -180.0;
  const bool touches_from_west = boxes.back().east_deg == 180.0;
  if (boxes.size() > 1) return boxes;
  if (touches_from_east) boxes.push_back({180.0, box.south_deg, 180.0, box.north_deg});
  if (touches_from_west) boxes.push_back({-180.0, box.south_deg, -180.0, box.north_deg});
  return boxes;
}

bool Meets(const BoundingBox& a, const BoundingBox& plain) {
  if (a.south_deg > plain.north_deg || a.north_deg < plain.south_deg) return false;
  const bool begins_before_end = a.west_deg <= plain.east_deg;
  const bool ends_after_begin = a.east_deg >= plain.west_deg;
  return a.west_deg <= a.east_deg ? begins_before_end && ends_after_begin
                                  : begins_before_end || ends_after_begin;
}

BoundingBox Unrolled(const BoundingBox& box) {
  const double east_deg = box.west_deg <= box.east_deg ? box.east_deg : box.east_deg + kTurnDeg;
  return {box.west_deg, box.south_deg, east_deg, box.north_deg};
}

BoundingBox Rolled(const BoundingBox& unrolled) {
  const double east_deg =
      unrolled.east_deg > 180.0 ? unrolled.east_deg - kTurnDeg : unrolled.east_deg;
  return {unrolled.west_deg, unrolled.south_deg, east_deg, unrolled.north_deg};
}

std::array<LongitudeSearch, 2> SearchesFor(const BoundingBox& box) {
  const std::vector<BoundingBox> parts = PlainBoxes(box);
  const double east_deg = parts.back().east_deg, west_deg = parts.front().west_deg;
  if (parts.size() == 1) {
    return {{{-kAnyDeg, east_deg, west_deg}, {east_deg, kAnyDeg, west_deg + kTurnDeg}}};
  }
  return {{{-kAnyDeg, east_deg, -kAnyDeg}, {east_deg, kAnyDeg, west_deg}}};
}

}  // namespace freelsd
