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

struct FixOptions {
  // Tried from the least upwards; offsets to either side.
  std::vector<double> climbs_m{25.0, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0};
  std::vector<double> offsets_m{100.0, 200.0, 300.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0};
  // The longest gaps get fixes.
  size_t max_num_gaps = 6;
  // Moments looked at to compare changes none of which closes the gap.
  size_t num_compared = 24;
  // A gap of which more than this share is left counts as not helped.
  double max_left_ratio = 0.5;
};

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

// The first climb and the first offset that close the gap and open no other are told. If none does,
// the one that leaves least is told, unless it leaves more than max_left_ratio of the gap.
FoundFixes FindFixes(const RouteJudge& judge,
                     const StoredSites& stored,
                     const RouteRequest& request,
                     const Insurance& insurance,
                     const FixOptions& options = {});

}  // namespace freelsd
