#include "api/import/poses/pose_columns.h"

#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

#include "api/import/import.h"
#include "api/import/poses/poses.h"

namespace freelsd {
namespace {

constexpr size_t kMaxShownNameBytes = 60;

// Largest number of names of a field.
constexpr size_t kMaxNumNames = 18;

struct FieldNames {
  PoseField field;
  std::string_view meta_pointer;
  // The contract's name first, then others in order of trust; unused entries are empty.
  std::array<std::string_view, kMaxNumNames> names;

  std::span<const std::string_view> Names() const {
    return {names.begin(), std::find(names.begin(), names.end(), std::string_view())};
  }
};

using F = PoseField;

constexpr FieldNames kFieldNames[] = {
    {F::kImage,
     "",
     {"image",
      "image_name",
      "file",
      "filename",
      "file_name",
      "img",
      "img_name",
      "imagename",
      "label",
      "photo",
      "picture",
      "sourcefile"}},
    {F::kLatitude,
     "/position/latitude_deg",
     {"latitude_deg",
      "lat_deg",
      "gps_lat_deg",
      "gps_latitude_deg",
      "latitude",
      "lat",
      "gps_lat",
      "gpslatitude",
      "y/latitude"}},
    {F::kLongitude,
     "/position/longitude_deg",
     {"longitude_deg",
      "lon_deg",
      "gps_lon_deg",
      "gps_longitude_deg",
      "longitude",
      "lon",
      "lng",
      "long",
      "gps_lon",
      "gpslongitude",
      "x/longitude"}},
    {F::kAltitude,
     "/position/altitude_m",
     {"altitude_m",
      "alt_m",
      "abs_alt_m",
      "gps_alt_m",
      "gps_height_m",
      "gps_altitude_m",
      "abs_altitude_m",
      "alt_amsl_m",
      "altitude_amsl_m",
      "alt_msl_m",
      "alt_hae_m",
      "altitude_hae_m",
      "altitude_ellipsoid_m",
      "ellipsoidal_height_m",
      "altitude",
      "alt",
      "gpsaltitude",
      "z/altitude"}},
    // Hemispheres and signs of exiftool's columns.
    {F::kLatitudeRef,
     "",
     {"gpslatituderef",
      "gps_latitude_ref",
      "gps_lat_ref",
      "latitude_ref",
      "latituderef",
      "lat_ref"}},
    {F::kLongitudeRef,
     "",
     {"gpslongituderef",
      "gps_longitude_ref",
      "gps_lon_ref",
      "longitude_ref",
      "longituderef",
      "lon_ref",
      "lng_ref"}},
    {F::kAltitudeRef,
     "",
     {"gpsaltituderef",
      "gps_altitude_ref",
      "gps_alt_ref",
      "altitude_ref",
      "altituderef",
      "alt_ref"}},
    {F::kTimestamp, "/timestamp_us", {"timestamp_us", "time_us"}},
    {F::kDateTime, "", {"utc", "utc_time", "time_utc", "local_time", "date_time", "datetime"}},
    {F::kRoll, "/attitude/roll_deg", {"roll_deg", "body_roll_deg", "roll"}},
    {F::kPitch, "/attitude/pitch_deg", {"pitch_deg", "body_pitch_deg", "pitch"}},
    {F::kYaw,
     "/attitude/yaw_deg",
     {"yaw_deg", "body_yaw_deg", "heading_deg", "body_heading_deg", "yaw"}},
    {F::kQuaternionW, "", {"qw", "q_w", "quat_w", "quaternion_w"}},
    {F::kQuaternionX, "", {"qx", "q_x", "quat_x", "quaternion_x"}},
    {F::kQuaternionY, "", {"qy", "q_y", "quat_y", "quaternion_y"}},
    {F::kQuaternionZ, "", {"qz", "q_z", "quat_z", "quaternion_z"}},
    {F::kGimbalRoll, "", {"gimbal_roll_deg", "camera_roll_deg"}},
    {F::kGimbalPitch, "", {"gimbal_pitch_deg", "camera_pitch_deg"}},
    {F::kGimbalYaw, "", {"gimbal_yaw_deg", "camera_yaw_deg"}},
    {F::kImageUpHeading, "", {"image_up_heading_deg", "image_top_heading_deg"}},
    {F::kWindEast, "/wind/east_mps", {"wind_east_mps"}},
    {F::kWindNorth, "/wind/north_mps", {"wind_north_mps"}},
    {F::kWindFrom,
     "",
     {"wind_from_deg", "wind_direction_from_deg", "wind_direction_deg", "wind_dir_deg"}},
    {F::kWindTo, "", {"wind_to_deg", "wind_direction_to_deg", "wind_towards_deg"}},
    {F::kWindSpeed, "", {"wind_speed_mps", "wind_speed"}},
    {F::kHeightAboveGround,
     "/height_above_ground_m",
     {"height_above_ground_m", "agl_m", "height_agl_m"}},
    {F::kHeightAboveTakeOff, "", {"rel_alt_m", "relative_altitude_m", "rel_altitude_m"}},
    {F::kPositionSd,
     "/position_sd_m",
     {"position_sd_m", "gps_xy_accuracy_m", "horizontal_accuracy_m"}},
    {F::kAttitudeSd, "/attitude_sd_deg", {"attitude_sd_deg"}},
};

const FieldNames& NamesOf(PoseField field) {
  return *std::find_if(std::begin(kFieldNames), std::end(kFieldNames), [field](const auto& each) {
    return each.field == field;
  });
}

// Lower case, without spaces and a comment's # around, "_" for spaces and what is not printable.
std::string Harmless(const std::string& name) {
  const size_t first = name.find_first_not_of(" \t\r#");
  if (first == std::string::npos) return "";
  std::string plain = name.substr(first, name.find_last_not_of(" \t\r") - first + 1);
  for (char& c : plain) {
    if (c <= ' ' || c > '~') c = '_';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return plain.substr(0, kMaxShownNameBytes);
}

ApiError Invalid(int line, const std::string& name, const std::string& detail) {
  return ApiError(
      "InvalidPoses", detail, {{"/poses/" + std::to_string(line) + "/" + name, detail}});
}

std::string IgnoredWarning(const std::string& name) {
  if (name.find("track") != std::string::npos || name.find("course") != std::string::npos) {
    return "column \"" + name + "\" is the track over ground, not the heading: ignored";
  }
  return "column \"" + name + "\" is unknown: ignored";
}

// Removes the quaternion if a part is missing, or if roll, pitch and yaw are all given.
PoseColumns WithOneAttitude(PoseColumns header) {
  const auto has = [&header](PoseField field) { return header.columns.contains(field); };
  if (std::none_of(kQuaternionFields.begin(), kQuaternionFields.end(), has)) return header;
  if (!std::all_of(kQuaternionFields.begin(), kQuaternionFields.end(), has)) {
    header.warnings.emplace_back("a quaternion needs qw, qx, qy and qz: ignored");
  } else if (has(PoseField::kRoll) && has(PoseField::kPitch) && has(PoseField::kYaw)) {
    header.warnings.emplace_back("roll, pitch and yaw are used, the quaternion is ignored");
  } else {
    header.warnings.emplace_back(
        "qw, qx, qy, qz are read as the rotation from body (forward, right, down) to north, east, "
        "down");
    return header;
  }
  for (const PoseField field : kQuaternionFields) header.columns.erase(field);
  return header;
}

}  // namespace

std::optional<std::string> PoseColumns::AltitudeDatum() const {
  const auto altitude = columns.find(PoseField::kAltitude);
  if (altitude == columns.end()) return std::nullopt;
  const std::string& name = altitude->second.name;
  if (name.find("msl") != std::string::npos) return "amsl";
  const bool is_ellipsoidal =
      name.find("hae") != std::string::npos || name.find("ellipsoid") != std::string::npos;
  return is_ellipsoidal ? std::optional<std::string>("ellipsoid") : std::nullopt;
}

std::string_view NameOf(PoseField field) { return NamesOf(field).names.front(); }

std::string_view MetaPointerOf(PoseField field) { return NamesOf(field).meta_pointer; }

size_t NumKnownColumns(const std::vector<std::string>& cells) {
  std::set<std::string> names;
  for (const std::string& cell : cells) names.insert(Harmless(cell));
  size_t num_known = 0;
  for (const FieldNames& field : kFieldNames) {
    for (const std::string_view known : field.Names()) num_known += names.count(std::string(known));
  }
  return num_known;
}

size_t NumKnownColumns(std::string_view line) {
  std::vector<std::string> cells(1);
  for (const char c : line.substr(0, kLimits.poses.max_header_bytes)) {
    if (c == ',' || c == ';' || c == '\t') {
      cells.emplace_back();
    } else if (c != '"') {
      cells.back() += c;
    }
  }
  return NumKnownColumns(cells);
}

PoseColumns ReadHeader(const CsvLine& line) {
  const std::vector<std::string>& cells = line.cells;
  if (cells.size() > kLimits.poses.max_num_columns) {
    throw Invalid(line.number, "", "the pose file has too many columns");
  }
  PoseColumns header;
  std::map<std::string, size_t> unclaimed;
  for (size_t i = 0; i < cells.size(); ++i) {
    const std::string name = Harmless(cells[i]);
    if (name.empty()) {
      header.unnamed.push_back(i);
    } else if (!unclaimed.emplace(name, i).second) {
      throw Invalid(line.number, name, "the column \"" + name + "\" comes twice");
    }
  }
  for (const FieldNames& field : kFieldNames) {
    for (const std::string_view known : field.Names()) {
      const auto found = unclaimed.find(std::string(known));
      if (found == unclaimed.end() || header.columns.count(field.field) != 0) continue;
      header.columns[field.field] = {found->second, found->first};
      unclaimed.erase(found);
    }
  }
  for (const PoseField needed :
       {PoseField::kImage, PoseField::kLatitude, PoseField::kLongitude, PoseField::kAltitude}) {
    const std::string name(NameOf(needed));
    if (header.columns.count(needed) == 0) {
      throw Invalid(line.number, name, "the column " + name + " is needed");
    }
  }
  for (const auto& [name, index] : unclaimed) header.warnings.push_back(IgnoredWarning(name));
  return WithOneAttitude(std::move(header));
}

}  // namespace freelsd
