#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/flight_parts.h"
#include "api/json_reader.h"
#include "api/stored/map/map.h"

namespace freelsd {
namespace {

constexpr int kHeadVersion = 1;

nlohmann::json VectorJson(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Eigen::Vector3d VectorOf(const nlohmann::json& array) {
  return {array.at(0).get<double>(), array.at(1).get<double>(), array.at(2).get<double>()};
}

Eigen::Vector2d Vector2Of(const nlohmann::json& x, const nlohmann::json& y) {
  return {x.get<double>(), y.get<double>()};
}

nlohmann::json ViewJson(const MapView& view) {
  const Eigen::Quaterniond& rotation = view.world_from_camera.rotation;
  nlohmann::json object{
      {"frame_id", view.frame_id},
      {"position_in_world_m", VectorJson(view.world_from_camera.translation)},
      {"world_from_camera_wxyz", {rotation.w(), rotation.x(), rotation.y(), rotation.z()}}};
  object["height_above_ground_m"] = view.height_above_ground;
  object["partners"] = view.partners;
  if (!view.readout.IsGlobal()) {
    for (int k = 0; k < Readout::kNumTurns; ++k) {
      object["turns_rad"].push_back(VectorJson(view.readout.turns.col(k)));
    }
  }
  return object;
}

MapView ViewOf(const nlohmann::json& object) {
  MapView view;
  view.frame_id = object.at("frame_id");
  view.world_from_camera.translation = VectorOf(object.at("position_in_world_m"));
  const nlohmann::json& wxyz = object.at("world_from_camera_wxyz");
  view.world_from_camera.rotation = {wxyz.at(0).get<double>(),
                                     wxyz.at(1).get<double>(),
                                     wxyz.at(2).get<double>(),
                                     wxyz.at(3).get<double>()};
  view.height_above_ground = object.at("height_above_ground_m");
  view.partners = object.at("partners").get<std::vector<size_t>>();
  if (object.contains("turns_rad")) {
    for (int k = 0; k < Readout::kNumTurns; ++k) {
      view.readout.turns.col(k) = VectorOf(object.at("turns_rad").at(k));
    }
  }
  return view;
}

nlohmann::json GridJson(const Grid& grid) {
  return {{"west_m", grid.north_west_in_world.x()},
          {"north_m", grid.north_west_in_world.y()},
          {"cell_size_m", grid.cell_size_m},
          {"num_rows", grid.num_rows},
          {"num_cols", grid.num_cols}};
}

Grid ReadGrid(const nlohmann::json& object) {
  Grid grid;
  grid.north_west_in_world = Vector2Of(object.at("west_m"), object.at("north_m"));
  grid.cell_size_m = object.at("cell_size_m");
  grid.num_rows = object.at("num_rows");
  grid.num_cols = object.at("num_cols");
  return grid;
}

nlohmann::json QualityJson(const BlockQuality& quality) {
  return {{"rms_before_px", quality.rms_before_px},
          {"rms_after_px", quality.rms_after_px},
          {"num_views", quality.num_views},
          {"num_connected_views", quality.num_connected_views},
          {"num_landmarks", quality.num_landmarks},
          {"note", quality.note}};
}

// A deviation may be unknown, which JSON cannot write as a number.
double DeviationOf(const nlohmann::json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

BlockQuality QualityOf(const nlohmann::json& object) {
  return {object.at("rms_before_px"),
          object.at("rms_after_px"),
          object.at("num_views"),
          object.at("num_connected_views"),
          object.at("num_landmarks"),
          object.at("note")};
}

}  // namespace

std::string MapHeadJson(const MapHead& head) {
  nlohmann::json views = nlohmann::json::array(), ranges = nlohmann::json::object();
  for (const MapView& view : head.views) views.push_back(ViewJson(view));
  for (const LayerRange& range : head.ranges) ranges[range.name] = {range.min, range.max};
  nlohmann::json object{{"version", kHeadVersion},
                        {"flight", head.flight_json},
                        {"origin", GeoPointJson(head.origin)},
                        {"grid", GridJson(head.grid)},
                        {"num_levels", head.num_levels},
                        {"position_sd_m", head.position_sd_m},
                        {"tilt_sd_deg", head.tilt_sd_deg},
                        {"is_compared", head.is_compared},
                        {"camera", CameraJson(head.camera)},
                        {"views", std::move(views)},
                        {"ranges", std::move(ranges)},
                        {"quality", QualityJson(head.quality)}};
  object["program_version"] = head.program_version;
  object["model_sha256"] = head.model_sha256;
  if (head.photo) {
    object["photo"] = {{"pixel_size_m", head.photo->pixel_size_m},
                       {"tile_size_px", head.photo->tile_size_px},
                       {"num_levels", head.photo->num_levels}};
  }
  if (head.wind) {
    object["wind_mps"] = {head.wind->wind_in_world.x(), head.wind->wind_in_world.y()};
    object["wind_spread_mps"] = head.wind->spread_mps;
  }
  return object.dump();
}

MapHead ParseMapHead(const std::string& text) {
  const nlohmann::json object = ParseJson(text);
  if (object.at("version") != kHeadVersion) {
    throw std::runtime_error("stored map: version " + object.at("version").dump());
  }
  MapHead head;
  head.flight_json = object.at("flight");
  head.origin = ReadGeoPoint(object.at("origin"), "/origin");
  head.grid = ReadGrid(object.at("grid"));
  head.num_levels = object.at("num_levels");
  head.position_sd_m = DeviationOf(object.at("position_sd_m"));
  head.tilt_sd_deg = DeviationOf(object.at("tilt_sd_deg"));
  head.is_compared = object.at("is_compared");
  head.camera = ParseCamera(object.at("camera"), "/camera", CameraOrigin::kStored);
  for (const nlohmann::json& view : object.at("views")) head.views.push_back(ViewOf(view));
  for (const MapView& view : head.views) {
    for (const size_t partner : view.partners) {
      if (partner >= head.views.size()) throw std::runtime_error("stored map: an impossible pair");
    }
  }
  head.program_version = object.at("program_version");
  head.model_sha256 = object.at("model_sha256");
  for (const auto& [name, range] : object.at("ranges").items()) {
    head.ranges.push_back({name, range.at(0), range.at(1)});
  }
  head.quality = QualityOf(object.at("quality"));
  if (object.contains("photo")) {
    const nlohmann::json& photo = object.at("photo");
    head.photo =
        PhotoLattice{photo.at("pixel_size_m"), photo.at("tile_size_px"), photo.at("num_levels")};
  }
  if (object.contains("wind_mps")) {
    const nlohmann::json& wind = object.at("wind_mps");
    head.wind = WindEstimate{.wind_in_world = Vector2Of(wind.at(0), wind.at(1)),
                             .spread_mps = object.at("wind_spread_mps")};
  }
  return head;
}

}  // namespace freelsd
