#include <nlohmann/json.hpp>

#include "api/frame_parts.h"
#include "api/stored/stored.h"

namespace freelsd {

std::string FrameMetaJson(const FrameMeta& meta) {
  nlohmann::json object = nlohmann::json::object();
  if (meta.timestamp_us) object["timestamp_us"] = *meta.timestamp_us;
  // Absent in the meta of clients, which is compared as text.
  if (meta.time_source != TimeSource::kGiven) object["time_source"] = NameOf(meta.time_source);
  if (meta.position) object["position"] = GeoPointJson(*meta.position);
  if (meta.altitude_datum) object["altitude_datum"] = *meta.altitude_datum;
  if (meta.ned_from_body) {
    object["ned_from_body_wxyz"] = QuaternionJson(WithPositiveW(*meta.ned_from_body));
  }
  if (meta.ned_from_camera) {
    object["ned_from_camera_wxyz"] = QuaternionJson(WithPositiveW(*meta.ned_from_camera));
  }
  if (meta.wind_in_world) {
    object["wind"] = {{"east_mps", meta.wind_in_world->x()},
                      {"north_mps", meta.wind_in_world->y()}};
  }
  if (meta.height_above_ground_m) object["height_above_ground_m"] = *meta.height_above_ground_m;
  if (meta.position_sd_m) object["position_sd_m"] = *meta.position_sd_m;
  if (meta.attitude_sd_deg) object["attitude_sd_deg"] = *meta.attitude_sd_deg;
  return object.dump();
}

FrameMeta ParseStoredFrameMeta(const std::string& text) {
  const nlohmann::json object = ParseJson(text);
  ObjectReader reader(object, "");
  FrameMeta meta = ReadCommonFrameFields(reader);
  if (const nlohmann::json* const source = reader.Find("time_source")) {
    meta.time_source = TimeSourceOf(source->get<std::string>()).value_or(TimeSource::kGiven);
  }
  if (const nlohmann::json* const body = reader.Find("ned_from_body_wxyz")) {
    meta.ned_from_body = ReadQuaternion(*body, "/ned_from_body_wxyz");
  }
  if (const nlohmann::json* const camera = reader.Find("ned_from_camera_wxyz")) {
    meta.ned_from_camera = ReadQuaternion(*camera, "/ned_from_camera_wxyz");
  }
  reader.RefuseUnknownKeys();
  return meta;
}

FrameMeta ParseStoredPose(const std::string& resolved_json,
                          const std::string& meta_json,
                          const std::string& tags_json) {
  if (!resolved_json.empty()) return ParseStoredFrameMeta(resolved_json);
  return Merged(ParseStoredFrameMeta(meta_json), ParseStoredFrameMeta(tags_json));
}

}  // namespace freelsd
