#include <cmath>
#include <utility>

#include "api/import/gimbal.h"
#include "api/import/images/image_camera.h"
#include "api/import/images/image_position.h"
#include "api/import/images/image_time.h"
#include "api/import/images/images.h"
#include "api/import/images/tag_source.h"
#include "api/import/number_text.h"

namespace freelsd {
namespace {

constexpr double kMaxPositionSd = 10000.0;
constexpr double kMaxHeight = 20000.0;
// Standard deviation of roll and pitch, assumed level, if only the heading is tagged.
constexpr double kUnknownTiltSdDeg = 8.0;
// Autopilots of survey planes tag exposures late and in turns, and their compass drifts. Compared
// with matches, tilts were 5 deg off and headings up to 20 deg.
constexpr double kTaggedAttitudeSdDeg = 5.0;
// No aircraft that maps flies steeper.
constexpr double kMaxTiltDeg = 45.0;

ImageTags WithPosition(ImageTags read, const TagSource& tags) {
  const TaggedPosition tagged = PositionFromTags(tags);
  read.meta.position = tagged.place;
  read.meta.altitude_datum = tagged.altitude_datum;
  read.why_no_position = tagged.why_not;
  read.warnings.insert(read.warnings.end(), tagged.warnings.begin(), tagged.warnings.end());
  const std::optional<double> sd = tags.XmpNumber("Camera", "GPSXYAccuracy");
  if (read.meta.position && sd && *sd > 0.0 && *sd < kMaxPositionSd) read.meta.position_sd_m = sd;
  return read;
}

EulerAngles Radians(double roll_deg, double pitch_deg, double yaw_deg) {
  return {RadFromDeg(roll_deg), RadFromDeg(pitch_deg), WrapAngle(RadFromDeg(yaw_deg))};
}

bool AreAllZero(double yaw, double pitch, double roll) {
  return yaw == 0.0 && pitch == 0.0 && roll == 0.0;
}

constexpr char kAllZero[] =
    "the camera's yaw, pitch and roll are all 0, which means unknown: they are not used";

// drone-dji:GimbalYawDegree and its like, drone-parrot:CameraYawDegree. They are of the camera:
// pitch 0 is level, -90 straight down.
ImageTags WithGimbal(ImageTags read, const TagSource& tags) {
  for (const std::string part : {"Gimbal", "Camera"}) {
    const std::optional<double> yaw = tags.XmpNumber("drone", part + "YawDegree");
    const std::optional<double> pitch = tags.XmpNumber("drone", part + "PitchDegree");
    if (!yaw || !pitch) continue;
    const double roll = tags.XmpNumber("drone", part + "RollDegree").value_or(0.0);
    if (!AreAllZero(*yaw, *pitch, roll)) {
      read.meta.ned_from_camera = NedFromGimbalCamera(Radians(roll, *pitch, *yaw));
      return read;
    }
    read.warnings.emplace_back(kAllZero);
  }
  return read;
}

// Sequoia, MicaSense and eMotion (Camera.Yaw ...) tag the aircraft's attitude; their camera looks
// down. Level flight is 0, 0, and the image's top is at the nose. Autel and others write the
// camera's angles there. Older senseFly aircraft tag a "Heading" that is the track over ground; it
// is not used.
ImageTags WithAircraftAngles(ImageTags read, const TagSource& tags) {
  const std::optional<double> yaw = tags.XmpNumber("Camera", "Yaw");
  if (!yaw) return read;
  const std::optional<double> pitch_tag = tags.XmpNumber("Camera", "Pitch");
  const std::optional<double> roll_tag = tags.XmpNumber("Camera", "Roll");
  const double pitch = pitch_tag.value_or(0.0), roll = roll_tag.value_or(0.0);
  if (pitch_tag && roll_tag && AreAllZero(*yaw, pitch, roll)) {
    read.warnings.emplace_back(kAllZero);
    return read;
  }
  const bool is_autel =
      tags.ExifText("Exif.Image.Make").value_or("").find("Autel") != std::string::npos;
  if ((pitch < -kMaxTiltDeg || is_autel) && std::abs(roll) <= kMaxTiltDeg) {
    read.meta.ned_from_camera = NedFromGimbalCamera(Radians(roll, pitch, *yaw));
    read.warnings.emplace_back(
        "Camera:Pitch is read as the camera's: 0 is the horizon, -90 straight down");
    return read;
  }
  if (std::abs(pitch) > kMaxTiltDeg || std::abs(roll) > kMaxTiltDeg) {
    read.warnings.emplace_back(
        "Camera:Pitch or Camera:Roll is steeper than an aircraft flies: the angles are not used");
    return read;
  }
  read.meta.ned_from_body = NedFromBody(Radians(roll, pitch, *yaw));
  read.meta.attitude_sd_deg = kTaggedAttitudeSdDeg;
  if (!pitch_tag || !roll_tag) {
    read.meta.attitude_sd_deg = kUnknownTiltSdDeg;
    read.warnings.emplace_back("only the heading is tagged: roll and pitch are assumed level");
  }
  return read;
}

// Height above take-off (DJI) or above ground (senseFly). Both are approximate.
std::optional<double> HeightAboveGround(const TagSource& tags) {
  std::optional<double> height = tags.XmpNumber("drone", "RelativeAltitude");
  if (!height) height = tags.XmpNumber("sensefly", "Height");
  if (!height || *height <= 0.0 || *height > kMaxHeight) return std::nullopt;
  return height;
}

// Viewers rotate the pixels but do not change the gimbal's angles.
bool WasEditedByViewer(const TagSource& tags) {
  const std::string tool = tags.XmpText("xmp", "CreatorTool").value_or("") +
                           tags.ExifText("Exif.Image.Software").value_or("");
  return tool.find("Photo Viewer") != std::string::npos;
}

// Properties of XMP whose loss would be noticed only by its consequences.
std::vector<std::string> UnreadNumbers(const TagSource& tags) {
  std::vector<std::string> warnings;
  for (const auto& [prefix, name] : {std::pair("drone", "GimbalYawDegree"),
                                     {"drone", "GimbalPitchDegree"},
                                     {"drone", "GimbalRollDegree"},
                                     {"drone", "CameraYawDegree"},
                                     {"drone", "CameraPitchDegree"},
                                     {"drone", "RelativeAltitude"},
                                     {"drone", "AbsoluteAltitude"},
                                     {"drone", "GpsLatitude"},
                                     {"drone", "GpsLongitude"},
                                     {"drone", "RtkFlag"},
                                     {"Camera", "Yaw"},
                                     {"Camera", "Pitch"},
                                     {"Camera", "Roll"}}) {
    const std::optional<std::string> text = tags.XmpText(prefix, name);
    if (!text || tags.XmpNumber(prefix, name)) continue;
    warnings.push_back("XMP: " + std::string(name) + " is no number: it is not used");
  }
  return warnings;
}

}  // namespace

ImageTags ReadImageTags(std::string_view bytes, const ImageHeader& header) {
  const TagSource tags(bytes);
  ImageTags read;
  TaggedCamera tagged = CameraFromTags(tags, header);
  read.camera = std::move(tagged.camera);
  read.camera_name = std::string(Trimmed(tags.ExifText("Exif.Image.Make").value_or("") + " " +
                                         tags.ExifText("Exif.Image.Model").value_or("")));
  read.warnings = std::move(tagged.warnings);
  if (!read.camera && !read.warnings.empty()) read.why_no_camera = read.warnings.back();
  for (const auto& more : {tags.warnings(), UnreadNumbers(tags)}) {
    read.warnings.insert(read.warnings.end(), more.begin(), more.end());
  }
  read = WithGimbal(WithPosition(std::move(read), tags), tags);
  if (!read.meta.ned_from_camera) read = WithAircraftAngles(std::move(read), tags);
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
