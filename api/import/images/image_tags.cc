#include <algorithm>
#include <cctype>
#include <cmath>

#include "api/import/gimbal.h"
#include "api/import/images/image_camera.h"
#include "api/import/images/image_time.h"
#include "api/import/images/images.h"
#include "api/import/images/tag_source.h"

namespace freelsd {
namespace {

// Same limits as for a client's meta. A tag outside them is wrong.
constexpr double kMinAltitude = -1000.0, kMaxAltitude = 20000.0;
constexpr double kMaxPositionSd = 10000.0;
constexpr char kAltitude[] = "Exif.GPSInfo.GPSAltitude";
constexpr char kAltitudeRef[] = "Exif.GPSInfo.GPSAltitudeRef";
// Values of GPSAltitudeRef; EXIF 3.0 has added those of the ellipsoid.
constexpr double kAboveSeaLevel = 0.0, kBelowSeaLevel = 1.0;
constexpr double kAboveEllipsoid = 2.0, kBelowEllipsoid = 3.0;
// Standard deviation of roll and pitch, assumed level, if only the heading is tagged.
constexpr double kUnknownTiltSdDeg = 8.0;
// Autopilots of survey planes tag exposures late and in turns, and their compass drifts. Compared
// with matches, tilts were 5 deg off and headings up to 20 deg.
constexpr double kTaggedAttitudeSdDeg = 5.0;

// Degrees, minutes, seconds with the hemisphere's letter.
std::optional<double> ExifAngle(const TagSource& tags, const std::string& name, char negative) {
  const std::string key = "Exif.GPSInfo.GPS" + name;
  const std::optional<double> degrees = tags.ExifNumber(key, 0);
  const std::optional<std::string> hemisphere = tags.ExifText(key + "Ref");
  if (!degrees || !hemisphere) return std::nullopt;
  const double angle = *degrees + tags.ExifNumber(key, 1).value_or(0.0) / 60.0 +
                       tags.ExifNumber(key, 2).value_or(0.0) / 3600.0;
  return (*hemisphere)[0] == negative ? -angle : angle;
}

std::optional<double> FirstOf(const std::optional<double>& first,
                              const std::optional<double>& second) {
  return first ? first : second;
}

std::optional<double> Latitude(const TagSource& tags) {
  return FirstOf(
      ExifAngle(tags, "Latitude", 'S'),
      FirstOf(tags.XmpNumber("drone", "GpsLatitude"), tags.XmpNumber("drone", "Latitude")));
}

std::optional<double> Longitude(const TagSource& tags) {
  // One firmware spells it with a superfluous t.
  return FirstOf(ExifAngle(tags, "Longitude", 'W'),
                 FirstOf(tags.XmpNumber("drone", "GpsLongitude"),
                         FirstOf(tags.XmpNumber("drone", "GpsLongtitude"),
                                 tags.XmpNumber("drone", "Longitude"))));
}

std::optional<double> Altitude(const TagSource& tags) {
  const std::optional<double> altitude = tags.ExifNumber(kAltitude);
  if (!altitude) return tags.XmpNumber("drone", "AbsoluteAltitude");
  const double reference = tags.ExifNumber(kAltitudeRef).value_or(0.0);
  const bool is_below = reference == kBelowSeaLevel || reference == kBelowEllipsoid;
  return is_below ? -*altitude : *altitude;
}

// XMP of DJI. A drone with RTK writes ellipsoidal altitudes, and yet calls them sea level in EXIF.
struct DjiAltitude {
  explicit DjiAltitude(const TagSource& tags)
      : type(tags.XmpText("drone", "AltitudeType").value_or("")),
        rtk_flag(tags.XmpNumber("drone", "RtkFlag")) {}

  // RtkFlag 0 is a receiver without a solution. The source of its altitude is unknown.
  bool IsFromRtk() const { return type == "RtkAlt" || (type.empty() && rtk_flag.value_or(0) > 0); }
  bool IsDoubtful() const {
    const bool is_from_barometer = type == "GpsFusionAlt" && rtk_flag.value_or(0) == 0;
    const bool is_silent = type.empty() && !rtk_flag;
    return !IsFromRtk() && !is_from_barometer && !is_silent;
  }

  std::string type;
  std::optional<double> rtk_flag;
};

// Pix4D's tag, which Sequoia, MicaSense and eMotion write too: "ellipsoidal", "EGM96", ...
std::optional<std::string> DatumOfVerticalSystem(const std::string& name) {
  const auto has = [&name](std::string_view word) {
    return std::search(name.begin(), name.end(), word.begin(), word.end(), [](char a, char b) {
             return std::tolower(static_cast<unsigned char>(a)) == b;
           }) != name.end();
  };
  if (has("ellips")) return "ellipsoid";
  if (has("egm") || has("msl") || has("sea level")) return "amsl";
  return std::nullopt;
}

// The most specific tag that states the datum is used. If tags contradict each other, the datum is
// unknown.
std::optional<std::string> AltitudeDatum(const TagSource& tags) {
  if (const auto system = tags.XmpText("Camera", "VertCS")) return DatumOfVerticalSystem(*system);
  const DjiAltitude dji(tags);
  if (dji.IsFromRtk()) return "ellipsoid";
  const std::optional<double> reference = tags.ExifNumber(kAltitudeRef);
  if (dji.IsDoubtful() || !reference || !tags.ExifNumber(kAltitude)) return std::nullopt;
  if (*reference == kAboveSeaLevel || *reference == kBelowSeaLevel) return "amsl";
  if (*reference == kAboveEllipsoid || *reference == kBelowEllipsoid) return "ellipsoid";
  return std::nullopt;
}

bool IsOnEarth(const GeoPoint& point) {
  // Receivers without a fix write zeros.
  const bool is_null_island = point.latitude_deg == 0.0 && point.longitude_deg == 0.0;
  return !is_null_island && std::abs(point.latitude_deg) <= 90.0 &&
         std::abs(point.longitude_deg) <= 180.0 && point.altitude_m >= kMinAltitude &&
         point.altitude_m <= kMaxAltitude;
}

ImageTags WithPosition(ImageTags read, const TagSource& tags) {
  const std::optional<double> latitude = Latitude(tags), longitude = Longitude(tags);
  const std::optional<double> altitude = Altitude(tags);
  if (!latitude && !longitude) return read;
  if (tags.ExifText("Exif.GPSInfo.GPSStatus").value_or("A") == "V") {
    read.warnings.emplace_back("the receiver had no fix: the geotag is not used");
  } else if (!latitude || !longitude || !altitude) {
    read.warnings.emplace_back("the geotag has no altitude or only one coordinate: it is not used");
  } else if (const GeoPoint point{*latitude, *longitude, *altitude}; IsOnEarth(point)) {
    read.meta.position = point;
    read.meta.altitude_datum = AltitudeDatum(tags);
  } else {
    read.warnings.emplace_back("the geotag is out of range: it is not used");
  }
  const std::optional<double> sd = tags.XmpNumber("Camera", "GPSXYAccuracy");
  if (read.meta.position && sd && *sd > 0.0 && *sd < kMaxPositionSd) read.meta.position_sd_m = sd;
  return read;
}

EulerAngles Radians(double roll_deg, double pitch_deg, double yaw_deg) {
  return {RadFromDeg(roll_deg), RadFromDeg(pitch_deg), WrapAngle(RadFromDeg(yaw_deg))};
}

// drone-dji:GimbalYawDegree and its like, drone-parrot:CameraYawDegree.
std::optional<EulerAngles> GimbalAngles(const TagSource& tags) {
  for (const std::string part : {"Gimbal", "Camera"}) {
    const std::optional<double> yaw = tags.XmpNumber("drone", part + "YawDegree");
    const std::optional<double> pitch = tags.XmpNumber("drone", part + "PitchDegree");
    if (!yaw || !pitch) continue;
    return Radians(tags.XmpNumber("drone", part + "RollDegree").value_or(0.0), *pitch, *yaw);
  }
  return std::nullopt;
}

// DJI and Parrot tag the camera's attitude: pitch 0 is level, -90 straight down. Sequoia,
// MicaSense and eMotion (Camera.Yaw ...) tag the aircraft's attitude; their camera looks down.
// Level flight is 0, 0, and the image's top is at the nose. Older senseFly aircraft tag a
// "Heading" that is the track over ground; it is not used.
ImageTags WithAttitude(ImageTags read, const TagSource& tags) {
  if (const std::optional<EulerAngles> gimbal = GimbalAngles(tags)) {
    read.meta.ned_from_camera = NedFromGimbalCamera(*gimbal);
    return read;
  }
  const std::optional<double> yaw = tags.XmpNumber("Camera", "Yaw");
  if (!yaw) return read;
  read.meta.attitude_sd_deg = kTaggedAttitudeSdDeg;
  const std::optional<double> pitch = tags.XmpNumber("Camera", "Pitch");
  const std::optional<double> roll = tags.XmpNumber("Camera", "Roll");
  read.meta.ned_from_body = NedFromBody(Radians(roll.value_or(0.0), pitch.value_or(0.0), *yaw));
  if (!pitch || !roll) {
    read.meta.attitude_sd_deg = kUnknownTiltSdDeg;
    read.warnings.emplace_back("only the heading is tagged: roll and pitch are assumed level");
  }
  return read;
}

// Height above take-off (DJI) or above ground (senseFly). Both are approximate.
std::optional<double> HeightAboveGround(const TagSource& tags) {
  const std::optional<double> height =
      FirstOf(tags.XmpNumber("drone", "RelativeAltitude"), tags.XmpNumber("sensefly", "Height"));
  if (!height || *height <= 0.0 || *height > kMaxAltitude) return std::nullopt;
  return height;
}

// Viewers rotate the pixels but do not change the gimbal's angles.
bool WasEditedByViewer(const TagSource& tags) {
  const std::string tool = tags.XmpText("xmp", "CreatorTool").value_or("") +
                           tags.ExifText("Exif.Image.Software").value_or("");
  return tool.find("Photo Viewer") != std::string::npos;
}

}  // namespace

ImageTags ReadImageTags(std::string_view bytes, const ImageHeader& header) {
  const TagSource tags(bytes);
  ImageTags read;
  TaggedCamera tagged = CameraFromTags(tags, header);
  read.camera = std::move(tagged.camera);
  read.warnings = std::move(tagged.warnings);
  read = WithAttitude(WithPosition(std::move(read), tags), tags);
  if (WasEditedByViewer(tags)) {
    read.warnings.emplace_back(
        "saved by a photo viewer: the pixels may be rotated, but not the attitude");
  }
  const TaggedTime time = TimeFromTags(tags);
  read.meta.timestamp_us = time.timestamp_us;
  read.meta.time_source = time.source;
  read.warnings.insert(read.warnings.end(), time.warnings.begin(), time.warnings.end());
  read.meta.height_above_ground_m = HeightAboveGround(tags);
  return read;
}

}  // namespace freelsd
