// Tags of EXIF and XMP, put into a JPEG as cameras do.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

namespace freelsd {

// The JPEG with one more APP1 segment.
inline std::string WithSegment(const std::string& jpeg, const std::string& payload) {
  const size_t length = payload.size() + 2;
  std::string segment("\xFF\xE1");
  segment += static_cast<char>(length >> 8);
  segment += static_cast<char>(length & 0xFF);
  return jpeg.substr(0, 2) + segment + payload + jpeg.substr(2);
}

// `attributes`: "drone-dji:RtkFlag='50' ...".
inline std::string WithXmpTags(const std::string& jpeg, const std::string& attributes) {
  const std::string header("http://ns.adobe.com/xap/1.0/\0", 29);
  return WithSegment(jpeg,
                     header +
                         "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF "
                         "xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>"
                         "<rdf:Description rdf:about='' "
                         "xmlns:drone-dji='http://www.dji.com/drone-dji/1.0/' "
                         "xmlns:drone-parrot='http://www.parrot.com/drone-parrot/1.0/' "
                         "xmlns:Camera='http://pix4d.com/camera/1.0/' " +
                         attributes + "/></rdf:RDF></x:xmpmeta>");
}

inline std::string LittleEndian(uint32_t number, size_t num_bytes) {
  std::string bytes;
  for (size_t i = 0; i < num_bytes; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFF);
  return bytes;
}

inline std::string TiffEntry(uint32_t tag, uint32_t type, uint32_t count, uint32_t value) {
  return LittleEndian(tag, 2) + LittleEndian(type, 2) + LittleEndian(count, 4) +
         LittleEndian(value, 4);
}

// A geotag of EXIF. North and east are positive.
struct Geotag {
  double latitude_deg = 47.0;
  double longitude_deg = 8.0;
  double altitude_m = 500.0;
  // GPSAltitudeRef: 0 above sea level, 1 below it, 2 above the ellipsoid, 3 below it.
  uint32_t altitude_reference = 0;
};

inline std::string WithGeotag(const std::string& jpeg, const Geotag& geotag) {
  constexpr uint32_t kByte = 1, kAscii = 2, kLong = 4, kRational = 5;
  constexpr uint32_t kGpsAt = 26, kLatitudeAt = 104, kLongitudeAt = 128, kAltitudeAt = 152;
  constexpr uint32_t kPerDegree = 10000000, kPerMetre = 1000;
  std::string tiff = "II*" + std::string(1, '\0') + LittleEndian(8, 4);
  tiff += LittleEndian(1, 2) + TiffEntry(0x8825, kLong, 1, kGpsAt) + LittleEndian(0, 4);
  tiff += LittleEndian(6, 2) + TiffEntry(1, kAscii, 2, geotag.latitude_deg < 0.0 ? 'S' : 'N') +
          TiffEntry(2, kRational, 3, kLatitudeAt) +
          TiffEntry(3, kAscii, 2, geotag.longitude_deg < 0.0 ? 'W' : 'E') +
          TiffEntry(4, kRational, 3, kLongitudeAt) +
          TiffEntry(5, kByte, 1, geotag.altitude_reference) +
          TiffEntry(6, kRational, 1, kAltitudeAt) + LittleEndian(0, 4);
  for (const double angle_deg : {geotag.latitude_deg, geotag.longitude_deg}) {
    const auto degrees = static_cast<uint32_t>(std::lround(std::abs(angle_deg) * kPerDegree));
    // Minutes and seconds are 0.
    for (const uint32_t number : {degrees, kPerDegree, 0u, 1u, 0u, 1u}) {
      tiff += LittleEndian(number, 4);
    }
  }
  tiff += LittleEndian(static_cast<uint32_t>(std::lround(geotag.altitude_m * kPerMetre)), 4) +
          LittleEndian(kPerMetre, 4);
  return WithSegment(jpeg, "Exif" + std::string(2, '\0') + tiff);
}

}  // namespace freelsd
