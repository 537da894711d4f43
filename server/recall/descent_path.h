// The path of a descent: which one an answer tells, and how its terrain is checked. Private to
// recall.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/approach/approach.h"
#include "engine/geometry/geometry.h"
#include "engine/glide/glide.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {

// From an aircraft to one site. Heights in world are in the site's datum.
struct DescentTask {
  GlideStart start;
  // With an approach.
  std::shared_ptr<const Plan> plan;
  // Without power.
  Aircraft aircraft;
  // Over all winds and headings to reckon with.
  Glide worst;
  LocalFrame local_frame;
  // Subtracted from altitudes of the request, which gives those of the site.
  double subtracted_m = 0.0;
};

struct ToldPath {
  // Nothing if the final is out of reach, or if no single path was found.
  std::optional<Descent> descent;
  // Least height of the path above stored terrain. The path is lowered in proportion to time, so
  // that it arrives at the height of the worst case. It ends at the start of the final, because the
  // planner has checked the circle and the final.
  std::optional<TerrainMargin> terrain;
  // Along the same path, and the airspaces that this path, the circle or the final enter.
  PathObstacles obstacles;
  // How far below the start of the final the worst case leads a pilot who flies a longer path to
  // its end, metres.
  double shortfall_m = 0.0;

  // Height that is left at the start of the final.
  double SurplusM() const { return descent ? descent->surplus_height_m : 0.0; }
};

// The shortest path. Where there is none, terrain and obstacles are those of a straight line.
ToldPath ShortestPath(const StoredSites& stored,
                      const EmergencyRequest& request,
                      const DescentTask& task);

// The first longer path that is as safe, or `shortest`, which keeps its surplus height. A longer
// path comes down to the start of the final. So it is checked more strictly:
// - The pilot may find in time that the aircraft is lower than told, as in the worst case, and
//   leaves out the rest of the longer way. After the last point where this helps, the worst case
//   may cost 5 m at most (shortfall_m), circles at the start of the final aside.
// - Its terrain is checked as above, but not below that shortfall. Near the start of the final,
//   terrain must stay below that height by the aircraft's safety margin and by the planner's
//   allowance for trees that the map misses.
// - Where less than the whole clearance is left, the site's own map must have seen the ground.
// - It clears every obstacle by the whole clearance. It meets no obstacle of unknown height and no
//   airspace that the shortest path does not meet.
ToldPath PathToTell(const StoredSites& stored,
                    const EmergencyRequest& request,
                    const RecallCandidate& candidate,
                    const DescentTask& task,
                    const ToldPath& shortest);

// Adds `path` (a LineString with altitudes), `times_s` (one for each vertex), and a warning if the
// wind may cost height that the path loses. `local_frame` is the approach's.
void AddPath(const ToldPath& told, const LocalFrame& local_frame, nlohmann::json& answer);

// Adds `obstacle_margin_m`, `nearest_obstacle` and `airspaces`, and warnings of obstacles with
// unknown height and of airspaces.
void AddObstacles(const PathObstacles& found, nlohmann::json& answer);

}  // namespace freelsd
