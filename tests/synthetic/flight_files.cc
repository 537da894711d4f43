#include "tests/synthetic/flight_files.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// 72 and 85 degrees across.
constexpr double kObliqueFocalPx = 1100.0;
constexpr double kWideFocalPx = 2200.0;
constexpr double kObliqueTiltDeg = 30.0;
constexpr double kPaperFocalPx = 465.0;
constexpr double kPaperWidthPx = 752.0;

double Rounded(double value, int num_digits) {
  const double scale = std::pow(10.0, num_digits);
  return std::round(value * scale) / scale;
}

Json LonLat(const LocalFrame& frame, const Eigen::Vector2d& place) {
  const GeoPoint geo = frame.GeoFromWorld({place.x(), place.y(), 0.0});
  return Json::array({Rounded(geo.longitude_deg, 8), Rounded(geo.latitude_deg, 8)});
}

Json FieldJson(const World& world,
               const LocalFrame& frame,
               const TrueField& field,
               const Aircraft& aircraft) {
  Json json;
  json["name"] = field.parcel.name;
  json["is_landable"] = field.is_landable;
  if (!field.reason.empty()) json["reason"] = field.reason;
  json["area_m2"] = Rounded(Area(field.parcel.outline), 1);
  Json outline = Json::array();
  for (const Eigen::Vector2d& corner : field.parcel.outline)
    outline.push_back(LonLat(frame, corner));
  json["outline"] = outline;
  if (field.touchdown) {
    json["touchdown"] = LonLat(frame, *field.touchdown);
    json["free_radius_m"] = Rounded(field.free_radius, 2);
    json["final_reserve_m"] = Rounded(FinalReserve(world, aircraft, *field.touchdown), 2);
    json["loiter_left_reserve_m"] = Rounded(LoiterReserve(world, aircraft, *field.touchdown, 1), 2);
    json["loiter_right_reserve_m"] =
        Rounded(LoiterReserve(world, aircraft, *field.touchdown, -1), 2);
  }
  return json;
}

Json ExposureJson(const LocalFrame& frame, const SyntheticExposure& exposure) {
  const GeoPoint geo = frame.GeoFromWorld(exposure.truth.position_in_world);
  Json json;
  json["image"] = exposure.image;
  json["timestamp_us"] = exposure.timestamp_us;
  json["latitude_deg"] = Rounded(geo.latitude_deg, 9);
  json["longitude_deg"] = Rounded(geo.longitude_deg, 9);
  json["altitude_m"] = Rounded(geo.altitude_m, 4);
  json["roll_deg"] = Rounded(DegFromRad(exposure.truth.attitude.roll), 5);
  json["pitch_deg"] = Rounded(DegFromRad(exposure.truth.attitude.pitch), 5);
  json["yaw_deg"] = Rounded(DegFromRad(exposure.truth.attitude.yaw), 5);
  return json;
}

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

Rig SyntheticRig(const std::string& name) {
  Rig rig;
  if (name == "paper") {
    rig.camera = PaperCamera(752, 480);
  } else if (name == "oblique") {
    rig.camera = PaperCamera(1600, 1200);
    rig.camera.fx_px = rig.camera.fy_px = kObliqueFocalPx;
    rig.body_from_camera.rotation =
        Eigen::AngleAxisd(RadFromDeg(kObliqueTiltDeg), Eigen::Vector3d::UnitY()) *
        rig.body_from_camera.rotation;
  } else if (name == "wide") {
    rig.camera = PaperCamera(4000, 3000);
    rig.camera.fx_px = rig.camera.fy_px = kWideFocalPx;
    rig.camera.distortion = DistortionModel::kRadTan;
    rig.camera.coefficients = {-0.12, 0.03, 0.0, 0.0};
  } else {
    throw std::invalid_argument("camera = " + name + ": must be paper, oblique or wide");
  }
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

std::string TruthJson(const World& world,
                      const std::vector<TrueField>& fields,
                      const std::vector<SyntheticExposure>& exposures,
                      const Aircraft& aircraft) {
  const LocalFrame frame(world.origin);
  Json json;
  json["seed"] = world.seed;
  json["origin"] = {{"latitude_deg", world.origin.latitude_deg},
                    {"longitude_deg", world.origin.longitude_deg},
                    {"altitude_m", world.origin.altitude_m}};
  json["size_m"] = world.size_m;
  json["wind"] = {{"east_mps", Rounded(world.wind_in_world.x(), 4)},
                  {"north_mps", Rounded(world.wind_in_world.y(), 4)}};
  json["aircraft_profile"] = aircraft.profile;
  json["fields"] = Json::array();
  for (const TrueField& field : fields) {
    json["fields"].push_back(FieldJson(world, frame, field, aircraft));
  }
  json["frames"] = Json::array();
  for (const SyntheticExposure& exposure : exposures) {
    json["frames"].push_back(ExposureJson(frame, exposure));
  }
  return json.dump(2) + "\n";
}

}  // namespace freelsd
