// Input: the track of a flight over a mosaic, and the touchdown that it was told. Output: what the
// aircraft met first, and whether that was a landing.
//
// The aircraft is a line across its track, as wide as its wings. Contact of its middle with free
// ground is a touchdown. Contact with anything else is a collision.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/evaluation/flown/mosaic.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct TrackPoint {
  double time_s = 0.0;
  GeoPoint place;
};

struct FlownTrack {
  std::string id;
  // At least two. After the touchdown they are the ground roll.
  std::vector<TrackPoint> points;
  // As told.
  GeoPoint touchdown;
  double touchdown_uncertainty_m = 0.0;
  // Of the final, radians clockwise from north.
  double heading = 0.0;
};

struct TrackVerdict {
  // False if the track ends in the air.
  bool has_contact = false;
  // Of the contact with what is no free ground: a cover, "wire", "steep", "rough"; or empty.
  std::string hit;
  // What lies in the way of the ground roll; or empty.
  std::string roll_fault;
  // Fences, poles and wires, which no photograph shows, are alone the reason.
  bool is_thin = false;
  bool is_in_disc = false;
  double time_s = 0.0;
  GeoPoint place;
  // From the told touchdown, along the final and to its left.
  double along_m = 0.0;
  double across_m = 0.0;
  double ground_speed_mps = 0.0;
  // As flown; at least the aircraft's.
  double roll_m = 0.0;

  bool IsLanding() const { return has_contact && hit.empty() && roll_fault.empty(); }
};

// Remembers the truth of worlds that it has judged. The mosaic must outlive it.
class TrackJudge {
 public:
  TrackJudge(const Mosaic& mosaic, const Aircraft& aircraft);

  // Throws std::invalid_argument for a track of fewer than two points.
  TrackVerdict Judge(const FlownTrack& track);

 private:
  struct Contact {
    bool is_free = false;
    std::string name;
    bool is_thin = false;
  };

  const TruthMap& TruthOf(const World& world);
  Contact ContactAt(const MosaicPlace& place);
  // At a place of the track, whose direction over ground is a unit vector.
  std::optional<Contact> FirstContact(const GeoPoint& place, const Eigen::Vector2d& direction);
  void JudgeRoll(const FlownTrack& track, const Eigen::Vector2d& direction, TrackVerdict& verdict);

  const Mosaic& mosaic_;
  Aircraft aircraft_;
  std::map<const World*, TruthMap> truths_;
};

}  // namespace freelsd
