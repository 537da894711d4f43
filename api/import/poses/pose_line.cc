#include "api/import/poses/pose_line.h"

#include <cctype>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/import/date_time.h"
#include "api/import/gimbal.h"
#include "api/import/number_text.h"

namespace freelsd {
namespace {

// Standard deviation if only the heading is known: a small plane without gimbal flies this level.
constexpr double kUnknownTiltSdDeg = 8.0;
constexpr double kMaxAngleDeg = 1e6;

// Nothing also for zeros, which cameras and tools write where no date is known.
std::optional<std::string> DateTimeText(const PoseLine& line) {
  const std::optional<std::string> text = line.Text(PoseField::kDateTime);
  if (!text) return std::nullopt;
  const size_t first = text->find_first_not_of(' ');
  const std::string trimmed = text->substr(first, text->find_last_not_of(" \r") - first + 1);
  if (trimmed.starts_with("0000")) return std::nullopt;
  return trimmed;
}

std::optional<int64_t> TimeOf(const PoseLine& line) {
  const std::optional<std::string> text = DateTimeText(line);
  if (!text) return std::nullopt;
  const std::optional<int64_t> time = TimestampFromText(*text);
  if (!time) {
    throw InvalidPose(line.Pointer(PoseField::kDateTime), "must be YYYY:MM:DD HH:MM:SS[.f]");
  }
  return time;
}

// Only the column's name or the text itself tells that a time is UTC.
TimeSource TimeSourceOf(const PoseLine& line) {
  const std::optional<std::string> text = DateTimeText(line);
  if (line.Text(PoseField::kTimestamp) || !text || HasOffset(*text)) return TimeSource::kGiven;
  const std::string& column = line.header().columns.at(PoseField::kDateTime).name;
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

// -1 or 1 by a column beside the number: the hemisphere's letter, or "below" and exiftool's 1 or 3.
double SignOf(const PoseLine& line, PoseField field, char positive, char negative) {
  const std::optional<std::string> text = line.Text(field);
  if (!text && !line.header().columns.contains(field)) return 1.0;
  const std::string trimmed(Trimmed(text.value_or("")));
  const char letter =
      static_cast<char>(std::toupper(static_cast<unsigned char>((trimmed + " ")[0])));
  if (letter == positive) return 1.0;
  if (letter == negative) return -1.0;
  const bool is_altitude = field == PoseField::kAltitudeRef;
  if (is_altitude && (letter == '0' || letter == '2' || letter == ' ')) return 1.0;
  if (is_altitude && (letter == '1' || letter == '3')) return -1.0;
  throw InvalidPose(line.Pointer(field),
                    std::string("must begin with ") + positive + " or " + negative);
}

// Columns beside latitude, longitude and altitude hold their signs. A number that has its sign
// already keeps it.
void ApplySigns(const PoseLine& line, nlohmann::json& position) {
  const auto apply = [&](const char* key, PoseField field, char positive, char negative) {
    const double sign = SignOf(line, field, positive, negative);
    if (!position.contains(key)) return;
    const double number = position[key].get<double>();
    const bool is_letter = line.Text(field) && field != PoseField::kAltitudeRef;
    if (number < 0.0 && sign > 0.0 && is_letter) {
      throw InvalidPose(line.Pointer(field),
                        std::string("is ") + positive + " of a negative number");
    }
    if (sign < 0.0) position[key] = -std::abs(number);
  };
  apply("latitude_deg", PoseField::kLatitudeRef, 'N', 'S');
  apply("longitude_deg", PoseField::kLongitudeRef, 'E', 'W');
  apply("altitude_m", PoseField::kAltitudeRef, 'A', 'B');
}

// Builds the same meta that a client would send, so that only one place checks ranges.
nlohmann::json MetaOf(const PoseLine& line) {
  nlohmann::json meta = nlohmann::json::object();
  for (const auto& [field, column] : line.header().columns) {
    const std::string pointer(MetaPointerOf(field));
    const std::optional<double> number = pointer.empty() ? std::nullopt : line.Number(field);
    if (number) meta[nlohmann::json::json_pointer(pointer)] = *number;
  }
  ApplySigns(line, meta["position"]);
  if (const std::optional<int64_t> time = TimeOf(line); time && !meta.contains("timestamp_us")) {
    meta["timestamp_us"] = *time;
  }
  if (const auto datum = line.header().AltitudeDatum()) meta["altitude_datum"] = *datum;
  if (const auto wind = WindOf(line); wind && !meta.contains("wind")) meta["wind"] = *wind;
  return meta;
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
  if (!heading) return std::nullopt;
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
  return line.Text(PoseField::kGimbalPitch) ||
         (line.Text(PoseField::kRoll) && line.Text(PoseField::kPitch));
}

// Checks required cells first: the error of a missing key in meta would be less clear.
void CheckNeeded(const PoseLine& line) {
  for (const PoseField field :
       {PoseField::kImage, PoseField::kLatitude, PoseField::kLongitude, PoseField::kAltitude}) {
    if (!line.Text(field)) throw InvalidPose(line.Pointer(field), "is needed and empty");
  }
  const bool has_east = line.Text(PoseField::kWindEast).has_value();
  if (has_east != line.Text(PoseField::kWindNorth).has_value()) {
    throw InvalidPose(has_east ? PointerToPair(line, PoseField::kWindEast, PoseField::kWindNorth)
                               : PointerToPair(line, PoseField::kWindNorth, PoseField::kWindEast),
                      "wind needs both components");
  }
}

// ParseFrameMeta's pointers name keys of meta, but the client's file has columns.
FrameMeta ParseMetaOfLine(const nlohmann::json& meta, const PoseLine& line) {
  try {
    return ParseFrameMeta(meta.dump());
  } catch (const ApiError& error) {
    const std::string at = error.errors().empty() ? "" : error.errors()[0].pointer;
    std::string pointer = LinePointer(line.number());
    if (at.rfind("/attitude/quaternion_wxyz", 0) == 0) {
      pointer = line.Pointer(PoseField::kQuaternionW);
    }
    for (const auto& [field, column] : line.header().columns) {
      if (!at.empty() && MetaPointerOf(field) == at) pointer = line.Pointer(field);
    }
    throw InvalidPose(pointer, error.what());
  }
}

}  // namespace

ApiError InvalidPose(const std::string& pointer, const std::string& detail) {
  return ApiError("InvalidPoses", detail, {{pointer, detail}});
}

std::string LinePointer(int line) { return "/poses/" + std::to_string(line); }

std::string PoseLine::Pointer(PoseField field) const {
  const auto column = header_.columns.find(field);
  const bool is_given = column != header_.columns.end();
  return LinePointer(line_.number) + "/" +
         (is_given ? column->second.name : std::string(NameOf(field)));
}

std::optional<std::string> PoseLine::Text(PoseField field) const {
  const auto column = header_.columns.find(field);
  if (column == header_.columns.end() || column->second.index >= line_.cells.size()) {
    return std::nullopt;
  }
  const std::string& cell = line_.cells[column->second.index];
  if (cell.find_first_not_of(" \t\r") == std::string::npos) return std::nullopt;
  return cell;
}

std::optional<double> PoseLine::Number(PoseField field) const {
  const std::optional<std::string> text = Text(field);
  if (!text) return std::nullopt;
  const std::optional<double> number = NumberFromText(*text);
  if (!number) throw InvalidPose(Pointer(field), "must be a finite number");
  return number;
}

std::optional<double> PoseLine::AngleRad(PoseField field) const {
  const std::optional<double> angle_deg = Number(field);
  if (!angle_deg) return std::nullopt;
  if (std::abs(*angle_deg) > kMaxAngleDeg) throw InvalidPose(Pointer(field), "is not an angle");
  return WrapAngle(RadFromDeg(*angle_deg));
}

FrameMeta ReadPoseLine(const PoseLine& line) {
  CheckNeeded(line);
  nlohmann::json meta_json = MetaOf(line);
  const bool has_yaw = line.Text(PoseField::kYaw).has_value();
  const std::optional<Eigen::Quaterniond> ned_from_camera = CameraAttitude(line);
  const std::optional<nlohmann::json> quaternion = QuaternionOf(line);
  const bool is_tilt_assumed = (ned_from_camera || (has_yaw && !quaternion)) && !HasTilt(line);
  if (quaternion) {
    meta_json["attitude"] = *quaternion;
  } else if (!has_yaw) {
    meta_json.erase("attitude");  // roll and pitch alone are no attitude
  } else {
    for (const char* const key : {"roll_deg", "pitch_deg"}) {
      if (!meta_json["attitude"].contains(key)) meta_json["attitude"][key] = 0.0;
    }
  }
  FrameMeta meta = ParseMetaOfLine(meta_json, line);
  meta.time_source = TimeSourceOf(line);
  if (ned_from_camera) {
    meta.ned_from_camera = ned_from_camera->normalized();
    meta.ned_from_body.reset();
  }
  if (is_tilt_assumed && !meta.attitude_sd_deg) meta.attitude_sd_deg = kUnknownTiltSdDeg;
  if (!meta.height_above_ground_m) {
    const std::optional<double> height = line.Number(PoseField::kHeightAboveTakeOff);
    if (height && *height > 0.0) meta.height_above_ground_m = height;
  }
  return meta;
}

}  // namespace freelsd
