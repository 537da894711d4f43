#include <cmath>
#include <stdexcept>

#include "api/import/angle_text.h"
#include "api/import/number_text.h"
#include "api/import/poses/pose_line.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kMaxAltitudeM = 20000.0;

struct Altitude {
  double altitude_m = 0.0;
  std::optional<std::string> datum;
};

bool HasWord(const std::string& text, const char* word) {
  return text.find(word) != std::string::npos;
}

// EXIF writes the side of sea level beside the number, or in a column of its own as 0 to 3.
std::optional<Altitude> AltitudeOf(const PoseLine& line) {
  const std::optional<std::string> text = line.Text(PoseField::kAltitude);
  if (!text) return std::nullopt;
  Altitude altitude{line.Number(PoseField::kAltitude).value(), line.header().AltitudeDatum()};
  if (!altitude.datum && line.frame().system->IsEllipsoidal()) altitude.datum = "ellipsoid";
  const std::string side =
      InLowerCase(line.Text(PoseField::kAltitudeRef).value_or("")) + " " + InLowerCase(*text);
  const auto begins = [&side](const char* letters) {
    return std::string_view(letters).find(side[0]) != std::string_view::npos;
  };
  if (!begins(" ab0123")) {
    throw InvalidPose(line.Pointer(PoseField::kAltitudeRef),
                      "must be Above or Below Sea Level, or a number from 0 to 3");
  }
  const bool is_below = HasWord(side, "below") || begins("b13");
  if (HasWord(side, "ellips")) {
    altitude.datum = "ellipsoid";
  } else if (HasWord(side, "sea level") || is_below || begins("02")) {
    altitude.datum = "amsl";
  }
  if (is_below) altitude.altitude_m = -std::abs(altitude.altitude_m);
  if (std::abs(altitude.altitude_m) > kMaxAltitudeM) {
    throw InvalidPose(line.Pointer(PoseField::kAltitude), "is beyond 20 km");
  }
  return altitude;
}

// The photograph's own, where the line has none.
Altitude AltitudeOrTag(const PoseLine& line, const std::string& image_id) {
  if (const std::optional<Altitude> given = AltitudeOf(line)) return *given;
  const auto tag = line.frame().tags.find(image_id);
  if (tag != line.frame().tags.end() && tag->second.position) {
    return {tag->second.position->altitude_m, tag->second.altitude_datum};
  }
  throw InvalidPose(line.Pointer(PoseField::kAltitude),
                    "has no value (z), and the photograph's own tags have no altitude");
}

GeoPoint FromXAndY(const PoseLine& line) {
  const TableFrame& frame = line.frame();
  const PoseField x_field = frame.is_swapped ? PoseField::kY : PoseField::kX;
  const PoseField y_field = frame.is_swapped ? PoseField::kX : PoseField::kY;
  const auto x = line.Number(x_field), y = line.Number(y_field);
  if (!x || !y) throw InvalidPose(line.Pointer(x ? y_field : x_field), "is needed and empty");
  try {
    return frame.system->PlaceOf(*x, *y);
  } catch (const std::invalid_argument& error) {
    const bool is_plane = !frame.is_system_told && std::abs(*x) + std::abs(*y) > 540.0;
    throw InvalidPose(line.Pointer(x_field),
                      is_plane ? "is an easting, but no coordinate system is told: the first line "
                                 "must be as EPSG:32632"
                               : error.what());
  }
}

// "47 deg 21' 3.60\" N, 8 deg 27' 20.88\" E".
GeoPoint FromOneCell(const PoseLine& line, const std::string& text) {
  const size_t comma = text.find(", ");
  const std::string_view both = text;
  const auto latitude = AngleFromText(both.substr(0, comma), Axis::kLatitude);
  const auto longitude = comma == std::string::npos
                             ? std::nullopt
                             : AngleFromText(both.substr(comma + 1), Axis::kLongitude);
  if (latitude && longitude) return {*latitude, *longitude, 0.0};
  throw InvalidPose(line.Pointer(PoseField::kLatitudeLongitude), "must be latitude, longitude");
}

GeoPoint LatitudeLongitude(const PoseLine& line) {
  const auto latitude = line.Coordinate(PoseField::kLatitude);
  const auto longitude = line.Coordinate(PoseField::kLongitude);
  if (latitude && longitude) return {*latitude, *longitude, 0.0};
  if (const auto both = line.Text(PoseField::kLatitudeLongitude)) return FromOneCell(line, *both);
  if (line.header().Has(PoseField::kX)) return FromXAndY(line);
  throw InvalidPose(line.Pointer(latitude ? PoseField::kLongitude : PoseField::kLatitude),
                    "is needed and empty");
}

// A latitude that can only be a longitude, beside a longitude that can be a latitude.
bool MayBeSwapped(const PoseLine& line) {
  const auto size = [&line](PoseField field) {
    return std::abs(NumberFromText(line.Text(field).value_or("")).value_or(1e3));
  };
  const double latitude_deg = size(PoseField::kLatitude);
  return latitude_deg > 90.0 && latitude_deg <= 180.0 && size(PoseField::kLongitude) <= 90.0;
}

}  // namespace

std::optional<double> PoseLine::Coordinate(PoseField field) const {
  const std::optional<std::string> text = Text(field);
  if (!text) return std::nullopt;
  const bool is_latitude = field == PoseField::kLatitude;
  const Axis axis = is_latitude ? Axis::kLatitude : Axis::kLongitude;
  const auto unit = header().columns.at(field).unit;
  const bool is_plain = unit && unit->factor != 1.0;
  // "1e1" is a number, not one degree east.
  const bool is_number =
      is_plain || (text->find_first_of("eE/") != std::string::npos && NumberFromText(*text));
  std::optional<double> angle_deg = is_number ? Number(field) : AngleFromText(*text, axis);
  if (!angle_deg || std::abs(*angle_deg) > (is_latitude ? 90.0 : 180.0)) {
    throw InvalidPose(Pointer(field),
                      std::string("must be a ") + (is_latitude ? "latitude" : "longitude") +
                          " in degrees" +
                          (MayBeSwapped(*this) ? ": latitude and longitude may be swapped" : ""));
  }
  const PoseField ref_field = is_latitude ? PoseField::kLatitudeRef : PoseField::kLongitudeRef;
  if (!header().Has(ref_field)) return angle_deg;
  angle_deg = AngleInHemisphere(*angle_deg, Text(ref_field).value_or(""), axis);
  if (!angle_deg) {
    throw InvalidPose(Pointer(ref_field),
                      is_latitude ? "must be N or S, as the sign of the latitude"
                                  : "must be E or W, as the sign of the longitude");
  }
  return angle_deg;
}

LinePlace PlaceOf(const PoseLine& line) {
  const std::optional<std::string> image = line.Text(PoseField::kImage);
  if (!image) throw InvalidPose(line.Pointer(PoseField::kImage), "is needed and empty");
  LinePlace read{LatitudeLongitude(line), {}};
  const Altitude altitude = AltitudeOrTag(line, ImageIdOf(*image, line.frame().tags));
  read.place.altitude_m = altitude.altitude_m;
  read.altitude_datum = altitude.datum;
  return read;
}

}  // namespace freelsd
