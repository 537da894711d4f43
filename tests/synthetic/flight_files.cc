#include "tests/synthetic/flight_files.h"

#include <cstdio>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kPaperFocalPx = 465.0;
constexpr double kPaperWidthPx = 752.0;

}  // namespace

Camera PaperCamera(int width_px, int height_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = kPaperFocalPx * width_px / kPaperWidthPx;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

Rig PaperRig() {
  Rig rig;
  rig.camera = PaperCamera(752, 480);
  return rig;
}

std::string PosesCsv(const World& world, const std::vector<SyntheticExposure>& exposures) {
  const LocalFrame frame(world.origin);
  std::string csv =
      "image,latitude_deg,longitude_deg,altitude_m,timestamp_us,roll_deg,pitch_deg,yaw_deg,"
      "wind_east_mps,wind_north_mps\n";
  for (const SyntheticExposure& exposure : exposures) {
    const GeoPoint geo = frame.GeoFromWorld(exposure.reported.position_in_world);
    char line[256];
    std::snprintf(line,
                  sizeof line,
                  "%s,%.8f,%.8f,%.3f,%lld,%.4f,%.4f,%.4f,%.3f,%.3f\n",
                  exposure.image.c_str(),
                  geo.latitude_deg,
                  geo.longitude_deg,
                  geo.altitude_m,
                  static_cast<long long>(exposure.timestamp_us),
                  DegFromRad(exposure.reported.attitude.roll),
                  DegFromRad(exposure.reported.attitude.pitch),
                  DegFromRad(exposure.reported.attitude.yaw),
                  exposure.reported_wind_in_world.x(),
                  exposure.reported_wind_in_world.y());
    csv += line;
  }
  return csv;
}

std::string FlightJson(const std::string& name, const Camera& camera, const std::string& profile) {
  Json json;
  json["name"] = name;
  json["camera"] = {{"width_px", camera.width_px},
                    {"height_px", camera.height_px},
                    {"fx_px", camera.fx_px},
                    {"fy_px", camera.fy_px},
                    {"cx_px", camera.cx_px},
                    {"cy_px", camera.cy_px},
                    {"distortion", {{"model", "none"}, {"coefficients", Json::array()}}}};
  json["altitude_datum"] = "amsl";
  json["aircraft"] = {{"profile", profile}};
  return json.dump(2) + "\n";
}

}  // namespace freelsd
