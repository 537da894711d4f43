#include "api/import/images/image_position.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>

#include "api/import/angle_text.h"
#include "api/import/number_text.h"

namespace freelsd {
namespace {

// Same limits as for a client's meta. A tag outside them is wrong.
constexpr double kMinAltitude = -1000.0, kMaxAltitude = 20000.0;
// The shores of the Dead Sea are at -430 m. All other land is above the second.
constexpr double kLowestLand = -450.0, kLowestUsualLand = -50.0;
// Above the difference of two datums.
constexpr double kMaxAltitudeDisagreement = 120.0;  // and in a sentence below
// Of one altitude in two units.
constexpr double kMaxFeetDisagreement = 2.0;
constexpr double kMaxPlaceDisagreementDeg = 0.01;
constexpr char kAltitude[] = "Exif.GPSInfo.GPSAltitude";
constexpr char kAltitudeRef[] = "Exif.GPSInfo.GPSAltitudeRef";
// Values of GPSAltitudeRef. EXIF 3.0 (4.6.7.1.6) has added 2 and 3 for sea level and made 0 and 1
// those of the ellipsoid; cameras go on to write 0 and 1 for sea level.
constexpr double kAbove = 0.0, kBelow = 1.0, kBelowSeaLevel = 3.0;

std::optional<double> FirstOf(const std::optional<double>& first,
                              const std::optional<double>& second) {
  return first ? first : second;
}

std::string Metres(double metres) { return std::to_string(std::lround(metres)) + " m"; }

struct AxisTags {
  std::string name;  // of EXIF, without GPS
  char positive;
  char negative;
  std::optional<double> xmp_deg;
};

// A latitude or longitude, or why EXIF has none.
struct Coordinate {
  std::optional<double> deg;
  std::string problem;
  std::string warning;
};

bool HasFraction(double number) {
  constexpr double kRounding = 1e-6;
  return std::abs(number - std::round(number)) > kRounding;
}

// Degrees, minutes, seconds without a sign.
Coordinate Angle(const std::string& name, std::vector<double> parts) {
  constexpr double kSixty = 60.0 + 1e-6;
  parts.resize(3, 0.0);
  const double degrees = parts[0], minutes = parts[1], seconds = parts[2];
  const bool is_in_range = minutes >= 0.0 && minutes < kSixty && seconds >= 0.0 && seconds < kSixty;
  if (!is_in_range || !std::isfinite(degrees)) {
    return {std::nullopt, name + " has minutes or seconds that are no number from 0 to 60", ""};
  }
  const bool is_twice =
      (HasFraction(degrees) && minutes + seconds > 0.0) || (HasFraction(minutes) && seconds > 0.0);
  if (is_twice) {
    return {std::nullopt, name + " has fractions of degrees or minutes beside smaller parts", ""};
  }
  return {std::abs(degrees) + minutes / 60.0 + seconds / 3600.0, "", ""};
}

// Degrees, minutes, seconds with the hemisphere's letter.
Coordinate FromExif(const TagSource& tags, const AxisTags& axis) {
  const std::string name = "GPS" + axis.name, key = "Exif.GPSInfo." + name;
  const std::vector<double> parts = tags.ExifNumbers(key);
  if (parts.empty()) return {};
  Coordinate read = Angle(name, parts);
  if (!read.deg) return read;
  const std::string hemisphere = tags.ExifText(key + "Ref").value_or("");
  const char letter =
      hemisphere.empty()
          ? ' '
          : static_cast<char>(std::toupper(static_cast<unsigned char>(hemisphere[0])));
  if (letter != axis.positive && letter != axis.negative) {
    return {std::nullopt,
            name + "Ref is missing or neither " + axis.positive + " nor " + axis.negative,
            ""};
  }
  if (parts[0] < 0.0 && letter == axis.positive) {
    return {std::nullopt, name + " is negative, and " + name + "Ref says " + axis.positive, ""};
  }
  if (letter == axis.negative) read.deg = -*read.deg;
  return read;
}

// Of DJI's schema, or of that of EXIF, which has "47,21.06N".
std::optional<double> XmpCoordinate(const TagSource& tags,
                                    const std::string& exif_name,
                                    Axis axis,
                                    std::initializer_list<const char*> dji_names) {
  for (const char* const name : dji_names) {
    if (const auto number = tags.XmpNumber("drone", name)) return number;
  }
  std::string text = tags.XmpText("exif", exif_name).value_or("");
  std::replace(text.begin(), text.end(), ',', ' ');
  return AngleFromText(text, axis);
}

// EXIF's coordinate, checked with XMP's, or XMP's.
Coordinate Combined(const TagSource& tags, const AxisTags& axis) {
  Coordinate exif = FromExif(tags, axis);
  if (!axis.xmp_deg) return exif;
  if (!exif.deg) {
    const bool is_told = !exif.problem.empty();
    return {axis.xmp_deg, "", is_told ? exif.problem + ": the place in XMP is used" : ""};
  }
  if (std::abs(*exif.deg - *axis.xmp_deg) < kMaxPlaceDisagreementDeg) return exif;
  if (std::abs(*exif.deg + *axis.xmp_deg) < kMaxPlaceDisagreementDeg) {
    return {std::nullopt, "EXIF and XMP name different hemispheres in GPS" + axis.name, ""};
  }
  exif.warning = "EXIF and XMP have different values of GPS" + axis.name + ": EXIF's is used";
  return exif;
}

// 0 to 3 as EXIF 3.0 has them; nothing without the tag. Some programs write the digit as text.
std::optional<double> AltitudeReference(const TagSource& tags) {
  const std::optional<std::string> text = tags.ExifText(kAltitudeRef);
  if (text && text->size() == 1 && std::isdigit(static_cast<unsigned char>((*text)[0])) != 0) {
    return (*text)[0] - '0';
  }
  const std::optional<double> number = tags.ExifNumber(kAltitudeRef);
  return number && *number >= '0' && *number <= '9' ? *number - '0' : number;
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
  const std::string lower = InLowerCase(name);
  const auto has = [&lower](const char* word) { return lower.find(word) != std::string::npos; };
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
  const std::optional<double> reference = AltitudeReference(tags);
  if (dji.IsDoubtful() || !reference || !tags.ExifNumber(kAltitude)) return std::nullopt;
  if (*reference > kBelowSeaLevel) return std::nullopt;
  return "amsl";
}

std::optional<double> ExifAltitude(const TagSource& tags) {
  const std::optional<double> altitude = tags.ExifNumber(kAltitude);
  const double reference = AltitudeReference(tags).value_or(kAbove);
  const bool is_below = reference == kBelow || reference == kBelowSeaLevel;
  return altitude && is_below ? -std::abs(*altitude) : altitude;
}

// Of the EXIF schema of XMP.
std::optional<double> ExifAltitudeInXmp(const TagSource& tags) {
  const std::optional<double> altitude = tags.XmpNumber("exif", "GPSAltitude");
  const bool is_below = tags.XmpNumber("exif", "GPSAltitudeRef") == kBelow;
  return altitude && is_below ? -std::abs(*altitude) : altitude;
}

struct TaggedAltitude {
  std::optional<double> metres;
  std::string warning;
};

// EXIF's altitude, or XMP's where EXIF has none, a placeholder, a wrong sign or a wrapped number.
TaggedAltitude Altitude(const TagSource& tags) {
  const std::optional<double> exif = ExifAltitude(tags);
  const std::optional<double> xmp = tags.XmpNumber("drone", "AbsoluteAltitude");
  const bool is_xmp_sane = xmp && *xmp != 0.0 && *xmp > kLowestLand && *xmp < kMaxAltitude;
  if (!exif || !is_xmp_sane) return {FirstOf(exif, FirstOf(xmp, ExifAltitudeInXmp(tags))), ""};
  const bool has_other_sign = *exif * *xmp < 0.0 && std::abs(*exif + *xmp) < 1.0;
  if (*exif != 0.0 && !has_other_sign && std::abs(*exif - *xmp) < kMaxAltitudeDisagreement) {
    return {exif, ""};
  }
  constexpr double kMetresPerFoot = 0.3048;
  if (*exif != 0.0 && std::abs(*exif - kMetresPerFoot * *xmp) < kMaxFeetDisagreement) {
    return {exif, "AbsoluteAltitude in XMP is GPSAltitude in feet: it is not used"};
  }
  // One sentence for all photographs of a flight, therefore without their numbers.
  const std::string what = *exif == 0.0     ? "is 0"
                           : has_other_sign ? "has the other sign than AbsoluteAltitude"
                                            : "is more than 120 m off AbsoluteAltitude";
  return {xmp, "GPSAltitude " + what + ": AbsoluteAltitude in XMP is used"};
}

// Why a geotag cannot be used; empty if it can.
std::string WhyNot(const GeoPoint& point) {
  // Receivers without a fix write zeros.
  const bool is_null_island = point.latitude_deg == 0.0 && point.longitude_deg == 0.0;
  if (point.altitude_m == 0.0 && !is_null_island) {
    return "GPSAltitude is 0, which cameras write where they do not know it";
  }
  if (point.altitude_m < kLowestLand && point.altitude_m >= kMinAltitude) {
    return "GPSAltitude is " + Metres(point.altitude_m) +
           ", below all land: is GPSAltitudeRef wrong?";
  }
  const bool is_on_earth = !is_null_island && std::abs(point.latitude_deg) <= 90.0 &&
                           std::abs(point.longitude_deg) <= 180.0 &&
                           point.altitude_m >= kMinAltitude && point.altitude_m <= kMaxAltitude;
  return is_on_earth ? "" : "the geotag is out of range";
}

// What the coordinates lack; empty if nothing.
std::string WhatIsMissing(const Coordinate& latitude,
                          const Coordinate& longitude,
                          const std::optional<double>& altitude) {
  for (const Coordinate* const each : {&latitude, &longitude}) {
    if (!each->deg && !each->problem.empty()) return each->problem;
  }
  if (!latitude.deg) return "the geotag has no latitude";
  if (!longitude.deg) return "the geotag has no longitude";
  return altitude ? "" : "the geotag has no altitude";
}

}  // namespace

TaggedPosition PositionFromTags(const TagSource& tags) {
  TaggedPosition read;
  // One firmware spells it with a superfluous t.
  const auto latitude_in_xmp =
      XmpCoordinate(tags, "GPSLatitude", Axis::kLatitude, {"GpsLatitude", "Latitude"});
  const auto longitude_in_xmp = XmpCoordinate(
      tags, "GPSLongitude", Axis::kLongitude, {"GpsLongitude", "GpsLongtitude", "Longitude"});
  const Coordinate latitude = Combined(tags, {"Latitude", 'N', 'S', latitude_in_xmp});
  const Coordinate longitude = Combined(tags, {"Longitude", 'E', 'W', longitude_in_xmp});
  const bool has_any =
      latitude.deg || longitude.deg || !latitude.problem.empty() || !longitude.problem.empty();
  if (!has_any) return read;
  const TaggedAltitude altitude = Altitude(tags);
  if (tags.ExifText("Exif.GPSInfo.GPSStatus").value_or("A") == "V") {
    read.why_not = "the receiver had no fix";
  } else {
    read.why_not = WhatIsMissing(latitude, longitude, altitude.metres);
  }
  if (read.why_not.empty()) {
    const GeoPoint place{*latitude.deg, *longitude.deg, *altitude.metres};
    read.why_not = WhyNot(place);
    if (read.why_not.empty()) read.place = place;
  }
  if (!read.place) {
    read.warnings.push_back(read.why_not + ": the geotag is not used");
    return read;
  }
  for (const std::string& warning : {latitude.warning, longitude.warning, altitude.warning}) {
    if (!warning.empty()) read.warnings.push_back(warning);
  }
  if (AltitudeReference(tags).value_or(kAbove) > kBelowSeaLevel) {
    read.warnings.emplace_back("GPSAltitudeRef is unknown: the datum of the altitude is not known");
  }
  read.altitude_datum = AltitudeDatum(tags);
  if (read.place->altitude_m < kLowestUsualLand) {
    read.warnings.push_back("GPSAltitude is " + Metres(read.place->altitude_m) +
                            ", below the sea: is GPSAltitudeRef wrong?");
  }
  return read;
}

}  // namespace freelsd
