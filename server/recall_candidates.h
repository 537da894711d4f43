// Which stored sites recall looks at, and in which order: by where they are, before any map is
// read.
#pragma once

#include <vector>

#include "server/emergency.h"

namespace freelsd {

// Sites beyond it are out of any small plane's reach; the box that is searched.
constexpr double kMaxReachM = 100000.0;

struct RecallCandidate {
  const RecallRow* row = nullptr;
  // East and north.
  Eigen::Vector2d way_m = Eigen::Vector2d::Zero();
  double distance_m = 0.0;
  double datum_penalty_m = 0.0;
  double score = 0.0;
  double age_s = 0.0;
  // Never less than the margin that the glide turns out to have.
  double best_margin_m = 0.0;
  // Straight to the site: about what it turns out to have.
  double expected_margin_m = 0.0;
};

BoundingBox BoxAround(const GeoPoint& place, double reach_m);
// As it glides: the request's aircraft and glide ratio come before the site's.
Aircraft AircraftOf(const EmergencyRequest& request, const Aircraft& site_aircraft);
GlideStart StartOf(const EmergencyRequest& request, const Eigen::Vector3d& position_in_world);
// No site lies lower, and no aircraft glides farther, than those this is for.
double GreatestReach(const EmergencyRequest& request, const RecallBounds& bounds);

// The `num_first` most promising ones first, best first; the rest in no order. They refer to the
// rows. Those whose aircraft cannot be used are left out.
std::vector<RecallCandidate> Candidates(const EmergencyRequest& request,
                                        const SharedRows<RecallRow>& rows,
                                        size_t num_first);

// Arrival margin, then verdict and score (which has aged), then age.
bool IsBetter(double margin_a,
              bool landable_a,
              const RecallCandidate& a,
              double margin_b,
              bool landable_b,
              const RecallCandidate& b);

}  // namespace freelsd
