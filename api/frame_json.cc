#include <sstream>

#include "api/frame_parts.h"

namespace freelsd {
namespace {

constexpr NumberRange kWindRange{-100.0, 100.0};
// Least positive value that makes sense; it implements "more than zero".
constexpr NumberRange kHeightRange{1e-3, 20000.0};
constexpr NumberRange kPositionSdRange{1e-3, 10000.0};
constexpr NumberRange kAttitudeSdRange{1e-3, 180.0};
constexpr NumberRange kPitchRange{-90.0, 90.0};

// {roll_deg, pitch_deg, yaw_deg} or {quaternion_wxyz}; ned_from_body.
Eigen::Quaterniond ReadAttitude(const nlohmann::json& value) {
  ObjectReader reader(value, "/attitude");
  if (const nlohmann::json* const wxyz = reader.Find("quaternion_wxyz")) {
    reader.RefuseUnknownKeys();
    return WithPositiveW(ReadQuaternion(*wxyz, "/attitude/quaternion_wxyz"));
  }
  EulerAngles attitude;
  attitude.roll = WrapAngle(RadFromDeg(reader.RequiredNumber("roll_deg")));
  attitude.pitch = RadFromDeg(reader.RequiredNumber("pitch_deg", kPitchRange));
  attitude.yaw = WrapAngle(RadFromDeg(reader.RequiredNumber("yaw_deg")));
  reader.RefuseUnknownKeys();
  return WithPositiveW(NedFromBody(attitude));
}

Eigen::Vector2d ReadWind(const nlohmann::json& value) {
  ObjectReader reader(value, "/wind");
  Eigen::Vector2d wind(reader.RequiredNumber("east_mps", kWindRange),
                       reader.RequiredNumber("north_mps", kWindRange));
  reader.RefuseUnknownKeys();
  return wind;
}

// The datum "unknown" is the same as no datum.
std::optional<std::string> ReadDatum(const nlohmann::json& value, bool has_position) {
  const std::string datum = ReadString(value, "/altitude_datum");
  if (datum != "amsl" && datum != "ellipsoid" && datum != "unknown") {
    throw InvalidValue("/altitude_datum",
                       "altitude_datum: must be one of amsl, ellipsoid, unknown");
  }
  if (!has_position) {
    throw InvalidValue("/altitude_datum", "altitude_datum: needs a position, whose altitude it is");
  }
  return datum == "unknown" ? std::nullopt : std::optional(datum);
}

std::optional<Eigen::Quaterniond> WorldFromBody(const FrameMeta& meta,
                                                const Rigid3d& body_from_camera) {
  if (meta.ned_from_camera) {
    const Eigen::Quaterniond camera_from_body = Inverse(body_from_camera).rotation;
    return (WorldFromNed() * *meta.ned_from_camera * camera_from_body).normalized();
  }
  if (meta.ned_from_body) return (WorldFromNed() * *meta.ned_from_body).normalized();
  return std::nullopt;
}

void CheckImageSize(const std::string& frame_id, const cv::Mat& image, const Camera& camera) {
  if (image.cols == camera.width_px && image.rows == camera.height_px) return;
  std::ostringstream detail;
  detail << "frame " << frame_id << ": image is " << image.cols << "x" << image.rows
         << ", camera says " << camera.width_px << "x" << camera.height_px;
  throw ApiError("ImageSizeMismatch", detail.str());
}

}  // namespace

Eigen::Quaterniond WithPositiveW(const Eigen::Quaterniond& q) {
  const double leading = q.w() != 0.0 ? q.w() : q.x() != 0.0 ? q.x() : q.y() != 0.0 ? q.y() : q.z();
  return leading < 0.0 ? Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

FrameMeta ReadCommonFrameFields(ObjectReader& reader) {
  FrameMeta meta;
  if (const nlohmann::json* const time = reader.Find("timestamp_us")) {
    meta.timestamp_us = ReadInteger(*time, "/timestamp_us");
  }
  if (const nlohmann::json* const position = reader.Find("position")) {
    meta.position = ReadGeoPoint(*position, "/position");
  }
  if (const nlohmann::json* const datum = reader.Find("altitude_datum")) {
    meta.altitude_datum = ReadDatum(*datum, meta.position.has_value());
  }
  if (const nlohmann::json* const wind = reader.Find("wind")) {
    meta.wind_in_world = ReadWind(*wind);
  }
  meta.height_above_ground_m = reader.Number("height_above_ground_m", kHeightRange);
  meta.position_sd_m = reader.Number("position_sd_m", kPositionSdRange);
  meta.attitude_sd_deg = reader.Number("attitude_sd_deg", kAttitudeSdRange);
  return meta;
}

FrameMeta ParseFrameMeta(const std::string& json_text) {
  const nlohmann::json object = ParseJson(json_text);
  ObjectReader reader(object, "");
  FrameMeta meta = ReadCommonFrameFields(reader);
  if (const nlohmann::json* const attitude = reader.Find("attitude")) {
    meta.ned_from_body = ReadAttitude(*attitude);
  }
  reader.RefuseUnknownKeys();
  return meta;
}

FrameMeta Merged(const FrameMeta& first, const FrameMeta& second) {
  FrameMeta merged = first;
  if (!first.timestamp_us) {
    merged.timestamp_us = second.timestamp_us;
    merged.time_source = second.time_source;
  }
  if (!first.position) {
    merged.position = second.position;
    merged.altitude_datum = second.altitude_datum;
    if (!first.position_sd_m) merged.position_sd_m = second.position_sd_m;
  }
  // An attitude of `first`, in either form, overrides both forms of `second`.
  if (!first.ned_from_body && !first.ned_from_camera) {
    merged.ned_from_body = second.ned_from_body;
    merged.ned_from_camera = second.ned_from_camera;
    if (!first.attitude_sd_deg) merged.attitude_sd_deg = second.attitude_sd_deg;
  }
  if (!first.wind_in_world) merged.wind_in_world = second.wind_in_world;
  if (!first.height_above_ground_m) merged.height_above_ground_m = second.height_above_ground_m;
  return merged;
}

Frame MakeFrame(const std::string& frame_id,
                const cv::Mat& image,
                const FrameMeta& meta,
                const Rig& rig,
                const LocalFrame& local_frame,
                int64_t fallback_timestamp_us) {
  if (!meta.position) {
    throw ApiError("NoPosition", "frame " + frame_id + ": no source gives a position");
  }
  CheckImageSize(frame_id, image, rig.camera);
  Frame frame;
  frame.id = frame_id;
  frame.timestamp_us = meta.timestamp_us.value_or(fallback_timestamp_us);
  frame.image = image;
  frame.prior.position_in_world = local_frame.WorldFromGeo(*meta.position);
  frame.prior.position_sd_m = meta.position_sd_m.value_or(frame.prior.position_sd_m);
  frame.prior.world_from_body = WorldFromBody(meta, rig.body_from_camera);
  frame.prior.attitude_sd_deg = meta.attitude_sd_deg.value_or(frame.prior.attitude_sd_deg);
  frame.wind_in_world = meta.wind_in_world;
  frame.height_above_ground = meta.height_above_ground_m;
  return frame;
}

}  // namespace freelsd
