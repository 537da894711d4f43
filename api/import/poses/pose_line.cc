#include "api/import/poses/pose_line.h"

#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/import/date_time.h"
#include "api/import/gimbal.h"
#include "api/import/number_text.h"
#include "api/import/poses/measure.h"

namespace freelsd {
namespace {

// Standard deviation if only the heading is known: a small plane without gimbal flies this level.
constexpr double kUnknownTiltSdDeg = 8.0;
constexpr double kMaxAngleDeg = 1e6;
// In the year 2255.
constexpr double kMaxTimeUs = 9e15;

// Only the column's name, the text itself, or a plain number tells that a time is UTC.
TimeSource TimeSourceOf(const PoseLine& line) {
  const std::optional<std::string> text = line.Text(PoseField::kTime);
  if (!text || NumberFromText(*text) || HasOffset(*text)) return TimeSource::kGiven;
  const std::string& column = line.header().columns.at(PoseField::kTime).name;
  return column.find("utc") == std::string::npos ? TimeSource::kCameraLocal : TimeSource::kGiven;
}

// Two fields need each other and one is missing. Returns its empty cell if it has a column, else
// the cell of the other field.
std::string PointerToPair(const PoseLine& line, PoseField given, PoseField missing) {
  return line.Pointer(line.header().columns.contains(missing) ? missing : given);
}

// Wind given by the direction it comes from or by the direction it blows to.
std::optional<nlohmann::json> WindOf(const PoseLine& line) {
  const bool is_from = line.Text(PoseField::kWindFrom).has_value();
  const PoseField direction = is_from || !line.header().columns.contains(PoseField::kWindTo)
                                  ? PoseField::kWindFrom
                                  : PoseField::kWindTo;
  const std::optional<double> angle = line.AngleRad(direction);
  const std::optional<double> speed_mps = line.Number(PoseField::kWindSpeed);
  if (!angle && !speed_mps) return std::nullopt;
  if (!angle) {
    throw InvalidPose(PointerToPair(line, PoseField::kWindSpeed, direction),
                      "wind needs both its direction and its speed");
  }
  if (!speed_mps) {
    throw InvalidPose(PointerToPair(line, direction, PoseField::kWindSpeed),
                      "wind needs both its direction and its speed");
  }
  if (*speed_mps < 0.0) throw InvalidPose(line.Pointer(PoseField::kWindSpeed), "is negative");
  const double towards_mps = direction == PoseField::kWindFrom ? -*speed_mps : *speed_mps;
  const Eigen::Vector2d towards = towards_mps * DirectionOf(*angle);
  return nlohmann::json{{"east_mps", towards.x()}, {"north_mps", towards.y()}};
}

bool IsPlace(PoseField field) {
  return field == PoseField::kLatitude || field == PoseField::kLongitude ||
         field == PoseField::kAltitude;
}

// Of a standard deviation: unknown, as programs write it.
bool IsUnknownZero(PoseField field, double number) {
  return number == 0.0 && (field == PoseField::kPositionSd || field == PoseField::kAttitudeSd);
}

// The value, or nothing where it throws.
template <typename Read>
auto Tolerated(const LeaveOut& leave_out, const Read& read) -> decltype(read()) {
  try {
    return read();
  } catch (const ApiError& error) {
    leave_out(error);
    return {};
  }
}

std::optional<nlohmann::json> WindComponentsOf(const PoseLine& line) {
  const auto east_mps = line.Number(PoseField::kWindEast);
  const auto north_mps = line.Number(PoseField::kWindNorth);
  if (!east_mps && !north_mps) return std::nullopt;
  if (east_mps && north_mps) return {{{"east_mps", *east_mps}, {"north_mps", *north_mps}}};
  throw InvalidPose(east_mps ? PointerToPair(line, PoseField::kWindEast, PoseField::kWindNorth)
                             : PointerToPair(line, PoseField::kWindNorth, PoseField::kWindEast),
                    "wind needs both components");
}

// Builds the same meta that a client would send, so that only one place checks ranges.
nlohmann::json MetaOf(const PoseLine& line, const LeaveOut& leave_out) {
  nlohmann::json meta = nlohmann::json::object();
  for (const auto& [field, column] : line.header().columns) {
    const std::string pointer(MetaPointerOf(field));
    if (pointer.empty() || IsPlace(field)) continue;
    const PoseField each = field;
    const auto number = Tolerated(leave_out, [&] { return line.Number(each); });
    if (number && !IsUnknownZero(field, *number)) {
      meta[nlohmann::json::json_pointer(pointer)] = *number;
    }
  }
  if (const auto time = Tolerated(leave_out, [&] { return line.Time(); })) {
    meta["timestamp_us"] = *time;
  }
  if (const auto wind = Tolerated(leave_out, [&] { return WindComponentsOf(line); })) {
    meta["wind"] = *wind;
  } else if (const auto from = Tolerated(leave_out, [&] { return WindOf(line); })) {
    meta["wind"] = *from;
  }
  return meta;
}

// Photogrammetry's: R = Rx(omega) Ry(phi) Rz(kappa) turns the picture's right, up and back to east,
// north and up.
std::optional<Eigen::Quaterniond> FromOmegaPhiKappa(const PoseLine& line) {
  const auto omega = line.AngleRad(PoseField::kOmega), phi = line.AngleRad(PoseField::kPhi),
             kappa = line.AngleRad(PoseField::kKappa);
  if (!omega || !phi || !kappa) return std::nullopt;
  const Eigen::Quaterniond world_from_picture =
      Eigen::AngleAxisd(*omega, Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(*phi, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(*kappa, Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond picture_from_camera(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  return WorldFromNed().conjugate() * world_from_picture * picture_from_camera;
}

// Camera attitude from gimbal angles or from the heading of the image's top. The heading overrides
// the gimbal's yaw because photographs may have been rotated after exposure.
std::optional<Eigen::Quaterniond> CameraAttitude(const PoseLine& line) {
  const std::optional<double> heading = line.AngleRad(PoseField::kImageUpHeading);
  const std::optional<double> yaw = line.AngleRad(PoseField::kGimbalYaw);
  const std::optional<double> pitch = line.AngleRad(PoseField::kGimbalPitch);
  const double roll = line.AngleRad(PoseField::kGimbalRoll).value_or(0.0);
  if (yaw && pitch) {
    const Eigen::Quaterniond ned_from_camera = NedFromGimbalCamera({roll, *pitch, *yaw});
    // Rotates the picture about the optical axis (camera z). The gimbal's axis does not change.
    const double turned = heading ? WrapAngle(*heading - *yaw) : 0.0;
    return ned_from_camera * Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitZ());
  }
  if (!heading) return FromOmegaPhiKappa(line);
  if (pitch) return NedFromGimbalCamera({roll, *pitch, *heading});
  return NedFromDownCamera({line.AngleRad(PoseField::kRoll).value_or(0.0),
                            line.AngleRad(PoseField::kPitch).value_or(0.0),
                            *heading});
}

std::optional<nlohmann::json> QuaternionOf(const PoseLine& line) {
  nlohmann::json wxyz = nlohmann::json::array();
  std::optional<PoseField> empty;
  for (const PoseField field : kQuaternionFields) {
    if (const std::optional<double> number = line.Number(field)) {
      wxyz.push_back(*number);
    } else {
      empty = field;
    }
  }
  if (wxyz.empty()) return std::nullopt;
  if (empty) throw InvalidPose(line.Pointer(*empty), "a quaternion needs all four numbers");
  return nlohmann::json{{"quaternion_wxyz", wxyz}};
}

bool HasTilt(const PoseLine& line) {
  return line.Text(PoseField::kGimbalPitch) || line.Text(PoseField::kOmega) ||
         (line.Text(PoseField::kRoll) && line.Text(PoseField::kPitch));
}

// ParseFrameMeta's pointers name keys of meta, but the client's file has columns. A value beyond
// its range is left out, until what remains is valid.
FrameMeta ParseMetaOfLine(nlohmann::json meta, const PoseLine& line, const LeaveOut& leave_out) {
  while (true) {
    std::string at;
    try {
      return ParseFrameMeta(meta.dump());
    } catch (const ApiError& error) {
      at = error.errors().empty() ? "" : error.errors()[0].pointer;
      std::string pointer = LinePointer(line.number());
      if (at.starts_with("/attitude/quaternion_wxyz"))
        pointer = line.Pointer(PoseField::kQuaternionW);
      for (const auto& [field, column] : line.header().columns) {
        if (!at.empty() && MetaPointerOf(field) == at) pointer = line.Pointer(field);
      }
      const std::string key = at.substr(0, at.find('/', 1)).substr(at.empty() ? 0 : 1);
      if (key.empty() || key == "position" || meta.erase(key) == 0) {
        throw InvalidPose(pointer, error.what());
      }
      leave_out(InvalidPose(pointer, error.what()));
    }
  }
}

bool HasZeroAngles(const PoseLine& line) {
  bool has_any = false;
  for (const PoseField field : kAngleFields) {
    const std::optional<std::string> text = line.Text(field);
    if (!text) continue;
    has_any = true;
    if (NumberFromText(*text) != 0.0) return false;
  }
  return has_any;
}

// Sets the attitude in `meta`, or returns that of the camera.
std::optional<Eigen::Quaterniond> TakeAttitude(const PoseLine& line, nlohmann::json& meta) {
  const std::optional<nlohmann::json> quaternion = QuaternionOf(line);
  std::optional<Eigen::Quaterniond> ned_from_camera = CameraAttitude(line);
  if (quaternion) {
    meta["attitude"] = *quaternion;
    return ned_from_camera;
  }
  nlohmann::json attitude = std::exchange(meta["attitude"], nullptr);
  meta.erase("attitude");
  // Roll and pitch alone are no attitude.
  if (!attitude.is_object() || !attitude.contains("yaw_deg")) return ned_from_camera;
  for (const auto& [key, field] :
       {std::pair{"roll_deg", PoseField::kRoll}, {"pitch_deg", PoseField::kPitch}}) {
    if (attitude.contains(key)) continue;
    // What is there and cannot be read is not level.
    if (line.Text(field)) return ned_from_camera;
    attitude[key] = 0.0;
  }
  meta["attitude"] = std::move(attitude);
  return ned_from_camera;
}

}  // namespace

ApiError InvalidPose(const std::string& pointer, const std::string& detail) {
  return ApiError("InvalidPoses", detail, {{pointer, detail}});
}

std::string LinePointer(int line) { return "/poses/" + std::to_string(line); }

std::string PoseLine::Pointer(PoseField field) const {
  const auto column = header().columns.find(field);
  const bool is_given = column != header().columns.end();
  return LinePointer(line_.number) + "/" +
         (is_given ? column->second.name : std::string(NameOf(field)));
}

std::optional<std::string> PoseLine::Text(PoseField field) const {
  const auto column = frame_.header.columns.find(field);
  if (column == frame_.header.columns.end() || column->second.index >= line_.cells.size()) {
    return std::nullopt;
  }
  const std::string& cell = line_.cells[column->second.index];
  if (cell.find_first_not_of(" \t\r") == std::string::npos) return std::nullopt;
  return cell;
}

std::optional<double> PoseLine::Number(PoseField field) const {
  const std::optional<std::string> text = Text(field);
  if (!text) return std::nullopt;
  const PoseColumns::Column& column = header().columns.at(field);
  const std::optional<double> number =
      MeasureFromText(*text, column.unit, QuantityOf(field), frame_.has_decimal_comma);
  if (!number) throw InvalidPose(Pointer(field), "must be a finite number");
  return number;
}

std::optional<int64_t> PoseLine::Time() const {
  const std::optional<std::string> text = Text(PoseField::kTime);
  // Zeros, which cameras and tools write where no date is known.
  if (!text || text->starts_with("0000")) return std::nullopt;
  if (const std::optional<double> number = NumberFromText(*text)) {
    const auto& unit = header().columns.at(PoseField::kTime).unit;
    // Without a unit, the only one that makes it a time of this century.
    const double magnitude = std::abs(*number);
    const double factor = unit               ? unit->factor
                          : magnitude < 1e11 ? 1e6
                          : magnitude < 1e14 ? 1e3
                                             : 1.0;
    if (magnitude * factor > kMaxTimeUs) throw InvalidPose(Pointer(PoseField::kTime), "is no time");
    return static_cast<int64_t>(std::llround(*number * factor));
  }
  const std::optional<int64_t> time = TimestampFromText(*text);
  if (!time) throw InvalidPose(Pointer(PoseField::kTime), "must be YYYY:MM:DD HH:MM:SS[.f]");
  return time;
}

std::optional<double> PoseLine::AngleRad(PoseField field) const {
  const std::optional<double> angle_deg = Number(field);
  if (!angle_deg) return std::nullopt;
  if (std::abs(*angle_deg) > kMaxAngleDeg) throw InvalidPose(Pointer(field), "is not an angle");
  return WrapAngle(RadFromDeg(*angle_deg));
}

FrameMeta ReadPoseLine(const PoseLine& line, const LeaveOut& leave_out) {
  const auto [place, altitude_datum] = PlaceOf(line);
  nlohmann::json meta_json = MetaOf(line, leave_out);
  meta_json["position"] = {{"latitude_deg", place.latitude_deg},
                           {"longitude_deg", place.longitude_deg},
                           {"altitude_m", place.altitude_m}};
  if (altitude_datum) meta_json["altitude_datum"] = *altitude_datum;
  std::optional<Eigen::Quaterniond> ned_from_camera;
  if (line.frame().are_zero_angles_unknown && HasZeroAngles(line)) {
    meta_json.erase("attitude");
  } else {
    ned_from_camera = Tolerated(leave_out, [&] { return TakeAttitude(line, meta_json); });
  }
  FrameMeta meta = ParseMetaOfLine(std::move(meta_json), line, leave_out);
  meta.time_source = TimeSourceOf(line);
  if (ned_from_camera) {
    meta.ned_from_camera = ned_from_camera->normalized();
    meta.ned_from_body.reset();
  }
  const bool has_attitude = meta.ned_from_camera || meta.ned_from_body;
  if (has_attitude && !meta.attitude_sd_deg) {
    const bool is_level = !HasTilt(line) && !line.Text(PoseField::kQuaternionW);
    meta.attitude_sd_deg = is_level ? kUnknownTiltSdDeg : line.header().attitude_sd_deg;
  }
  if (!meta.height_above_ground_m) {
    const std::optional<double> height =
        Tolerated(leave_out, [&] { return line.Number(PoseField::kHeightAboveTakeOff); });
    if (height && *height > 0.0) meta.height_above_ground_m = height;
  }
  return meta;
}

}  // namespace freelsd
