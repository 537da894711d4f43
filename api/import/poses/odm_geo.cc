// geo.txt of OpenDroneMap: a coordinate system, then image x y z [yaw pitch roll] [accuracies].
#include <algorithm>
#include <cmath>

#include <GeographicLib/UTMUPS.hpp>

#include "api/import/gimbal.h"
#include "api/import/number_text.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr size_t kFirstAngle = 4;
constexpr size_t kFirstAccuracy = 7;
// Aircraft tilt less than this. If angles are larger, they are not yaw, pitch, roll.
constexpr double kMaxTiltDeg = 45.0;
constexpr double kMaxUsualTiltDeg = 15.0;
// Standard deviation. The format defines its angles poorly; a nadir camera is assumed.
constexpr double kAttitudeSdDeg = 5.0;

// Zone 0: longitude and latitude.
struct Projection {
  int utm_zone = 0;
  bool is_north = true;
  // True if the third coordinate is a height above the ellipsoid. Otherwise its datum is unknown.
  bool is_ellipsoidal = false;
};

bool HasWord(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string Lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

std::optional<Projection> Utm(const std::string& zone_text, bool is_north) {
  const std::optional<double> zone = NumberFromText(zone_text);
  if (!zone || *zone < 1 || *zone > 60 || *zone != std::floor(*zone)) return std::nullopt;
  return Projection{static_cast<int>(*zone), is_north};
}

std::optional<Projection> ProjectionOf(const std::string& line) {
  const std::string header = Lower(line);
  const std::vector<std::string> words = WordsOf(header);
  if (header.rfind("epsg:", 0) == 0) {
    const std::string code = words[0].substr(5);
    if (code == "4326") return Projection{};
    if (code == "4979") return Projection{.is_ellipsoidal = true};
    if (code.size() != 5) return std::nullopt;
    if (code.rfind("326", 0) == 0) return Utm(code.substr(3), true);
    if (code.rfind("327", 0) == 0) return Utm(code.substr(3), false);
    return std::nullopt;
  }
  if (words.size() == 3 && words[0] == "wgs84" && words[1] == "utm" && words[2].size() > 1) {
    const char pole = words[2].back();
    if (pole != 'n' && pole != 's') return std::nullopt;
    return Utm(words[2].substr(0, words[2].size() - 1), pole == 'n');
  }
  const bool is_wgs84 = HasWord(words, "+datum=wgs84") || HasWord(words, "+ellps=wgs84");
  if (!is_wgs84) return std::nullopt;
  if (HasWord(words, "+proj=longlat") || HasWord(words, "+proj=latlong")) return Projection{};
  if (!HasWord(words, "+proj=utm")) return std::nullopt;
  for (const std::string& word : words) {
    if (word.rfind("+zone=", 0) == 0) return Utm(word.substr(6), !HasWord(words, "+south"));
  }
  return std::nullopt;
}

// x, y: longitude and latitude, in this order, or easting and northing.
GeoPoint PlaceOf(const std::vector<double>& xyz,
                 const Projection& projection,
                 const SideFile& file,
                 int line) {
  GeoPoint place{xyz[1], xyz[0], xyz[2]};
  if (projection.utm_zone != 0) {
    try {
      GeographicLib::UTMUPS::Reverse(projection.utm_zone,
                                     projection.is_north,
                                     xyz[0],
                                     xyz[1],
                                     place.latitude_deg,
                                     place.longitude_deg);
    } catch (const GeographicLib::GeographicErr&) {
      throw InvalidSideFile(file, line, "easting and northing are not in this zone");
    }
  }
  if (std::abs(place.latitude_deg) > 90.0 || std::abs(place.longitude_deg) > 180.0) {
    throw InvalidSideFile(
        file, line, "is not on the earth: x is the longitude and comes first, y the latitude");
  }
  return place;
}

struct GeoLine {
  std::string image_id;
  FrameMeta meta;
  // Yaw, pitch, roll in degrees; empty where not given or all zero.
  std::vector<double> angles_deg;
};

GeoLine ReadLine(const TextLine& line, const Projection& projection, const SideFile& file) {
  const std::vector<std::string> words = WordsOf(line.text);
  if (words.size() < 4) throw InvalidSideFile(file, line.number, "must be: image x y z");
  GeoLine read;
  read.image_id = IdFromFileName(words[0]);
  read.meta.position =
      PlaceOf(NumbersOf(words, 1, kFirstAngle, file, line.number), projection, file, line.number);
  if (projection.is_ellipsoidal) read.meta.altitude_datum = "ellipsoid";
  if (words.size() >= kFirstAccuracy) {
    read.angles_deg = NumbersOf(words, kFirstAngle, kFirstAccuracy, file, line.number);
    // "Can be set to 0 if they are not available."
    if (read.angles_deg == std::vector<double>(3, 0.0)) read.angles_deg.clear();
  }
  if (words.size() > kFirstAccuracy) {
    const double accuracy =
        NumbersOf(words, kFirstAccuracy, kFirstAccuracy + 1, file, line.number)[0];
    if (accuracy > 0.0) read.meta.position_sd_m = accuracy;
  }
  return read;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Some programs write omega, phi, kappa into the same columns. The two angles that are small in a
// flight of a camera that looks down tell which they are. Kappa must not be read as roll.
bool AreYawPitchRoll(const std::vector<GeoLine>& lines) {
  std::vector<double> first_deg, last_deg;
  for (const GeoLine& line : lines) {
    if (line.angles_deg.empty()) continue;
    if (std::abs(line.angles_deg[1]) > kMaxTiltDeg || std::abs(line.angles_deg[2]) > kMaxTiltDeg) {
      return false;
    }
    first_deg.push_back(std::abs(line.angles_deg[0]));
    last_deg.push_back(std::abs(line.angles_deg[2]));
  }
  return MedianOf(last_deg) <= kMaxUsualTiltDeg && MedianOf(first_deg) > MedianOf(last_deg);
}

// At pitch 0 the camera looks straight down; yaw is the heading of the image's top.
void SetAttitude(GeoLine& line) {
  line.meta.ned_from_camera = NedFromDownCamera({RadFromDeg(line.angles_deg[2]),
                                                 RadFromDeg(line.angles_deg[1]),
                                                 RadFromDeg(line.angles_deg[0])});
  line.meta.attitude_sd_deg = kAttitudeSdDeg;
}

}  // namespace

void ReadOdmGeo(const SideFile& file, SideData& data) {
  const std::vector<TextLine> lines = LinesOf(file.text);
  const std::optional<Projection> projection = ProjectionOf(lines.at(0).text);
  if (!projection) {
    throw InvalidSideFile(file,
                          lines[0].number,
                          "only EPSG:4326, EPSG:326zz, EPSG:327zz, WGS84 UTM zzN and their PROJ "
                          "forms are supported");
  }
  std::vector<GeoLine> read;
  for (size_t i = 1; i < lines.size(); ++i) read.push_back(ReadLine(lines[i], *projection, file));
  const bool has_angles = std::any_of(
      read.begin(), read.end(), [](const GeoLine& line) { return !line.angles_deg.empty(); });
  const bool are_used = has_angles && AreYawPitchRoll(read);
  if (has_angles) {
    data.file.warnings.push_back(
        are_used ? "geo.txt: the angles are taken as yaw, pitch, roll of a nadir camera"
                 : "CameraAnglesIgnored: geo.txt: the angles are no yaw, pitch, roll (omega, phi, "
                   "kappa?)");
  }
  for (GeoLine& line : read) {
    if (are_used && !line.angles_deg.empty()) SetAttitude(line);
    data.file.poses.emplace_back(line.image_id, line.meta);
  }
}

}  // namespace freelsd
