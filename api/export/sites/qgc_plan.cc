#include "api/export/sites/sites.h"

namespace freelsd {
namespace {

// MAV_AUTOPILOT_PX4, MAV_AUTOPILOT_ARDUPILOTMEGA; vehicle class fixed wing.
constexpr int kPx4Autopilot = 12;
constexpr int kArduPilotAutopilot = 3;
constexpr int kFixedWing = 1;
// Only displayed; the pilot's own settings override them.
constexpr double kShownCruiseMps = 15.0;
constexpr double kShownHoverMps = 5.0;

}  // namespace

std::string QgcPlanFile(const QgcPlan& plan, Firmware firmware) {
  const bool is_ardupilot = firmware == Firmware::kArduPilot;
  const nlohmann::json mission{{"version", 2},
                               {"firmwareType", is_ardupilot ? kArduPilotAutopilot : kPx4Autopilot},
                               {"vehicleType", kFixedWing},
                               {"cruiseSpeed", kShownCruiseMps},
                               {"hoverSpeed", kShownHoverMps},
                               {"globalPlanAltitudeMode", plan.is_above_home ? 1 : 2},
                               {"plannedHomePosition", plan.home},
                               {"items", plan.items}};
  const nlohmann::json fence{
      {"version", 2}, {"polygons", nlohmann::json::array()}, {"circles", nlohmann::json::array()}};
  const nlohmann::json file{{"fileType", "Plan"},
                            {"version", 1},
                            {"groundStation", "QGroundControl"},
                            {"mission", mission},
                            {"geoFence", fence},
                            {"rallyPoints", {{"version", 2}, {"points", plan.rally_points}}},
                            {"freelsd", plan.remarks}};
  return file.dump(2) + "\n";
}

}  // namespace freelsd
