#include "api/import/images/image_time.h"

#include <cmath>
#include <cstdlib>
#include <tuple>

#include "api/import/date_time.h"

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;
// Offsets from UTC are multiples of a quarter of an hour.
constexpr int64_t kQuarterUs = 15 * 60 * kSecondUs;
// Receivers tag whole seconds, and the fix of a moment before. A camera's clock that is so near is
// right, and tells the moment of exposure better.
constexpr int64_t kMaxFixAgeUs = 3 * kSecondUs;
constexpr int64_t kRolloverUs = 1024 * 7 * int64_t{86400} * kSecondUs;

// The camera's clock, read as UTC where the tags tell no offset.
struct CameraTime {
  int64_t timestamp_us = 0;
  bool has_offset = false;
};

std::optional<int64_t> IfPlausible(const std::optional<int64_t>& time_us) {
  return time_us && *time_us >= kEarliestCaptureUs ? time_us : std::nullopt;
}

std::optional<int64_t> ReceiverTime(const TagSource& tags) {
  constexpr char kTimeOfDay[] = "Exif.GPSInfo.GPSTimeStamp";
  if (tags.ExifText("Exif.GPSInfo.GPSStatus").value_or("A") == "V") return std::nullopt;
  const std::optional<std::string> date = tags.ExifText("Exif.GPSInfo.GPSDateStamp");
  const std::optional<int64_t> day = date ? TimestampFromText(*date + " 00:00:00") : std::nullopt;
  const auto hour = tags.ExifNumber(kTimeOfDay, 0), minute = tags.ExifNumber(kTimeOfDay, 1),
             second = tags.ExifNumber(kTimeOfDay, 2);
  if (!day || !hour || !minute || !second) return std::nullopt;
  const double second_of_day = 3600.0 * *hour + 60.0 * *minute + *second;
  if (!(second_of_day >= 0.0 && second_of_day <= 86401.0)) return std::nullopt;
  return *day + std::llround(second_of_day * static_cast<double>(kSecondUs));
}

// DJI tags the moment of exposure in UTC; XMP has EXIF's time of the receiver in one text.
std::optional<int64_t> UtcTime(const TagSource& tags) {
  for (const auto& [prefix, name] :
       {std::pair("drone", "UTCAtExposure"), {"exif", "GPSTimeStamp"}}) {
    const std::optional<std::string> text = tags.XmpText(prefix, name);
    const auto time = IfPlausible(text ? TimestampFromText(*text) : std::nullopt);
    if (time) return time;
  }
  return IfPlausible(ReceiverTime(tags));
}

std::optional<CameraTime> TimeOfExif(const TagSource& tags) {
  // Names of exiv2, and of the offsets of EXIF 2.31, which it does not know. The last one is of the
  // file: a program that edits the photograph may change it.
  for (const auto& [name, suffix, offset_name] :
       {std::tuple("Exif.Photo.DateTimeOriginal", "Original", "Exif.Photo.0x9011"),
        {"Exif.Photo.DateTimeDigitized", "Digitized", "Exif.Photo.0x9012"},
        {"Exif.Image.DateTime", "", "Exif.Photo.0x9010"}}) {
    const std::optional<std::string> text = tags.ExifText(name);
    const std::optional<int64_t> time = IfPlausible(text ? TimestampFromText(*text) : std::nullopt);
    if (!time) continue;
    const std::string fraction =
        tags.ExifText(std::string("Exif.Photo.SubSecTime") + suffix).value_or("0");
    const std::string offset_text =
        tags.ExifText(offset_name)
            .value_or(tags.ExifText(std::string("Exif.Photo.OffsetTime") + suffix).value_or(""));
    const std::optional<int64_t> offset = OffsetFromText(offset_text);
    return CameraTime{*time + FractionFromText(fraction).value_or(0) - offset.value_or(0),
                      offset.has_value() || HasOffset(*text)};
  }
  return std::nullopt;
}

std::optional<CameraTime> TimeOfXmp(const TagSource& tags) {
  for (const auto& [prefix, name] : {std::pair("exif", "DateTimeOriginal"),
                                     {"photoshop", "DateCreated"},
                                     {"xmp", "CreateDate"},
                                     {"xmp", "ModifyDate"}}) {
    const std::optional<std::string> text = tags.XmpText(prefix, name);
    const std::optional<int64_t> time = text ? TimestampFromText(*text) : std::nullopt;
    if (time) return CameraTime{*time, HasOffset(*text)};
  }
  return std::nullopt;
}

std::optional<CameraTime> ClockTime(const TagSource& tags) {
  const std::optional<CameraTime> exif = TimeOfExif(tags), xmp = TimeOfXmp(tags);
  const bool is_xmp_better = xmp && xmp->has_offset && !(exif && exif->has_offset);
  return exif && !is_xmp_better ? exif : xmp;
}

// In whole days, if no offset from UTC explains the difference.
std::string WrongClock(int64_t behind_us) {
  const int64_t hours = std::abs(behind_us) / (3600 * kSecondUs);
  const std::string much =
      hours < 48 ? std::to_string(hours) + " hours" : std::to_string(hours / 24) + " days";
  return "the camera's clock is " + much + (behind_us > 0 ? " behind" : " ahead of") +
         " the receiver's time, which is used";
}

}  // namespace

TaggedTime TimeFromTags(const TagSource& tags) {
  const std::optional<int64_t> utc = UtcTime(tags);
  const std::optional<CameraTime> clock = ClockTime(tags);
  // Old receivers count weeks to 1024 and begin again.
  const std::optional<int64_t> receiver = ReceiverTime(tags);
  if (clock && receiver &&
      std::abs(*receiver + kRolloverUs - clock->timestamp_us) <= kMaxUtcOffsetUs + kQuarterUs) {
    return {*receiver + kRolloverUs,
            TimeSource::kGps,
            {"the receiver's date is 1024 weeks behind the camera's: its week number has rolled "
             "over and is corrected"}};
  }
  if (!utc) {
    if (!clock) return {};
    const TimeSource source = clock->has_offset ? TimeSource::kCamera : TimeSource::kCameraLocal;
    return {clock->timestamp_us, source, {}};
  }
  if (!clock) return {*utc, TimeSource::kGps, {}};
  const int64_t behind_us = *utc - clock->timestamp_us;
  if (std::abs(behind_us) > kMaxUtcOffsetUs + kQuarterUs) {
    return {*utc, TimeSource::kGps, {WrongClock(behind_us)}};
  }
  const int64_t offset_us =
      kQuarterUs * std::llround(static_cast<double>(behind_us) / static_cast<double>(kQuarterUs));
  const bool is_clock_right = std::abs(behind_us - offset_us) <= kMaxFixAgeUs;
  return {is_clock_right ? clock->timestamp_us + offset_us : *utc, TimeSource::kGps, {}};
}

}  // namespace freelsd
