// What a later map positively shows of a site's ground. Ground that the map only fails to recognise
// as fit (snow, another season or light, a less accurate map) may not have changed. Private to
// recall.
#pragma once

#include <functional>
#include <optional>

#include "server/maps/maps.h"
#include "server/recall/plan_check.h"

namespace freelsd {

// A part of a map, in the world of its origin. With cues, if the map has them.
struct ShownGround {
  GeoPoint origin;
  MapRasters rasters;
};
// The ground under a plan, on the map that the plan was made on. Nothing if it cannot be read.
using OwnGround = std::function<std::optional<ShownGround>()>;

struct EvidenceOptions {
  // Deviations, of both maps together, from which a difference in height is a change.
  double height_sigma = 3.0;
  // Least size of what stands or is dug. Single cells may be outliers.
  double min_size_m = 2.0;
  // Cells that both maps measured, between which they are levelled: the least number.
  size_t min_num_common_cells = 100;
  // A less accurate map shows no change: positions differ by more than this.
  double max_shift_m = 20.0;
  // Photographs are like the training's if the views recognise grass, with this probability, in
  // this share of the later map's cells. Others may show snow. What cues say then is no evidence.
  double min_grass_probability = 0.95;
  double min_recognised_ratio = 0.5;
};

// What breaks of the plan if its own map is changed only by what the later map positively shows:
// - heights that differ after both maps were levelled and shifted within their deviations,
// - small objects and fences, and
// - what stands in the way where the own map saw nothing.
// Nothing if the plan holds with these changes.
std::optional<PlanCheck> BrokenByEvidence(const StoredPlan& plan,
                                          const ShownGround& own,
                                          const ShownGround& later,
                                          const EvidenceOptions& options);

}  // namespace freelsd
