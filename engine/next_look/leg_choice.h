// Private to next_look/: the leg that promises most.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/next_look/landing_squares.h"
#include "engine/next_look/leg_views.h"

namespace freelsd {

// How all legs are flown.
struct LookFlight {
  PhotoShape shape;
  double photo_spacing_m = 0.0;
  // Of the request.
  const std::function<void()>& before_leg;
};

struct ChosenLeg {
  LegLine line;
  double expected_gain = 0.0;
  // Known shares once it is flown.
  cv::Mat1f known;
};

// All legs with both ends in the area.
std::vector<LegLine> LegsIn(const Box& area,
                            const LookFlight& flight,
                            const NextLookOptions& options);

// Nothing if no leg promises anything.
std::optional<ChosenLeg> BestLeg(const std::vector<LegLine>& legs,
                                 const std::vector<LandingSquare>& squares,
                                 const KnownGround& ground,
                                 const LookFlight& flight,
                                 const NextLookOptions& options);

}  // namespace freelsd
