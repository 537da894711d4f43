// The smallest changes of a route that close its gaps. Private to recall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/recall/route/insurance.h"

namespace freelsd {

enum class FixKind {
  kClimb,   // fly a part higher
  kOffset,  // fly a part further aside
  kLook,    // photograph this ground first: a strip there would close the gap
};
const char* NameOf(FixKind kind);

// A change that shortens one gap.
struct RouteFix {
  FixKind kind = FixKind::kClimb;
  // Index of the gap.
  size_t gap = 0;
  // kClimb; kOffset: to the right of the gap's direction, negative to its left.
  double climb_m = 0.0;
  double offset_m = 0.0;
  // The changed route, unless kLook.
  std::vector<GeoPoint> route;
  // kLook: the ground, at the altitude that is assumed for it.
  std::optional<GeoPoint> place;
  // Seconds of all gaps of the route with this change alone. For kLook they are those that a strip
  // there leaves if it can be landed on in every direction.
  double gaps_left_s = 0.0;
};

struct FoundFixes {
  std::vector<RouteFix> fixes;
  // False if the deadline came before all gaps were looked at.
  bool is_complete = true;
};

// Climbs and offsets are tried from the least upwards (kClimbsM, kOffsetsM); the first one that
// closes the gap and opens no other is told. If none does, the one that leaves least is told,
// unless it leaves more than half of the gap. Only the longest gaps get fixes.
FoundFixes FindFixes(const RouteJudge& judge,
                     const StoredSites& stored,
                     const RouteRequest& request,
                     const Insurance& insurance);

}  // namespace freelsd
