// Tags of EXIF and XMP, put into a JPEG as cameras do.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

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
                         "xmlns:Camera='http://pix4d.com/camera/1.0/' "
                         "xmlns:xmp='http://ns.adobe.com/xap/1.0/' "
                         "xmlns:exif='http://ns.adobe.com/exif/1.0/' " +
                         attributes + "/></rdf:RDF></x:xmpmeta>");
}

inline std::string LittleEndian(uint32_t number, size_t num_bytes) {
  std::string bytes;
  for (size_t i = 0; i < num_bytes; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFF);
  return bytes;
}

constexpr uint32_t kByteType = 1, kAsciiType = 2, kLongType = 4, kRationalType = 5;

struct TiffTag {
  uint32_t tag = 0;
  uint32_t type = kAsciiType;
  uint32_t count = 1;
  std::string value;
};

inline TiffTag AsciiTag(uint32_t tag, const std::string& text) {
  const std::string value = text + std::string(1, '\0');
  return {tag, kAsciiType, static_cast<uint32_t>(value.size()), value};
}

// A folder of tags that begins `at` bytes after the start of the TIFF.
inline std::string TiffFolder(const std::vector<TiffTag>& tags, size_t at) {
  const auto num_tags = static_cast<uint32_t>(tags.size());
  std::string entries = LittleEndian(num_tags, 2), values;
  const size_t values_at = at + 2 + 12 * tags.size() + 4;
  for (const TiffTag& tag : tags) {
    std::string value = tag.value;
    if (value.size() > 4) {
      value = LittleEndian(static_cast<uint32_t>(values_at + values.size()), 4);
      values += tag.value;
    }
    value.resize(4, '\0');
    entries += LittleEndian(tag.tag, 2) + LittleEndian(tag.type, 2) + LittleEndian(tag.count, 4);
    entries += value;
  }
  return entries + LittleEndian(0, 4) + values;
}

// The JPEG with EXIF's folders of the receiver, of the photograph and of the image.
inline std::string WithExif(const std::string& jpeg,
                            const std::vector<TiffTag>& gps,
                            const std::vector<TiffTag>& photo,
                            std::vector<TiffTag> root = {}) {
  const auto place = [](size_t at) { return LittleEndian(static_cast<uint32_t>(at), 4); };
  const size_t num_root_tags = root.size() + 2;
  size_t photo_at = 8 + 2 + 12 * num_root_tags + 4;
  for (const TiffTag& tag : root) photo_at += tag.value.size() > 4 ? tag.value.size() : 0;
  const std::string photo_folder = TiffFolder(photo, photo_at);
  root.push_back({0x8769, kLongType, 1, place(photo_at)});
  root.push_back({0x8825, kLongType, 1, place(photo_at + photo_folder.size())});
  return WithSegment(jpeg,
                     "Exif" + std::string(2, '\0') + "II*" + std::string(1, '\0') +
                         LittleEndian(8, 4) + TiffFolder(root, 8) + photo_folder +
                         TiffFolder(gps, photo_at + photo_folder.size()));
}

// A rational, or several, of EXIF.
inline TiffTag RationalTag(uint32_t tag, const std::vector<std::pair<uint32_t, uint32_t>>& parts) {
  std::string value;
  for (const auto& [number, per] : parts) value += LittleEndian(number, 4) + LittleEndian(per, 4);
  return {tag, kRationalType, static_cast<uint32_t>(parts.size()), value};
}

// A geotag of EXIF. North and east are positive.
struct Geotag {
  double latitude_deg = 47.0;
  double longitude_deg = 8.0;
  double altitude_m = 500.0;
  // GPSAltitudeRef: 0 above sea level, 1 below it, 2 above the ellipsoid, 3 below it.
  uint32_t altitude_reference = 0;
};

// Times as EXIF has them; empty: not tagged.
struct PhotoTimes {
  std::string taken;                 // "2024:06:01 12:00:00"
  std::string offset;                // "+02:00"
  std::string gps_date;              // "2024:06:01"
  std::vector<uint32_t> gps_time{};  // hours, minutes, seconds
};

inline std::string WithGeotag(const std::string& jpeg,
                              const Geotag& geotag,
                              const PhotoTimes& times = {}) {
  constexpr uint32_t kPerDegree = 10000000, kPerMetre = 1000;
  const auto rational = [](uint32_t number, uint32_t per) {
    return LittleEndian(number, 4) + LittleEndian(per, 4);
  };
  // Minutes and seconds are 0.
  const auto angle = [&](double angle_deg) {
    const auto degrees = static_cast<uint32_t>(std::lround(std::abs(angle_deg) * kPerDegree));
    return rational(degrees, kPerDegree) + rational(0, 1) + rational(0, 1);
  };
  const auto altitude = static_cast<uint32_t>(std::lround(geotag.altitude_m * kPerMetre));
  std::vector<TiffTag> gps{AsciiTag(1, geotag.latitude_deg < 0.0 ? "S" : "N"),
                           {2, kRationalType, 3, angle(geotag.latitude_deg)},
                           AsciiTag(3, geotag.longitude_deg < 0.0 ? "W" : "E"),
                           {4, kRationalType, 3, angle(geotag.longitude_deg)},
                           {5, kByteType, 1, LittleEndian(geotag.altitude_reference, 1)},
                           {6, kRationalType, 1, rational(altitude, kPerMetre)}};
  if (!times.gps_time.empty()) {
    std::string time;
    for (const uint32_t part : times.gps_time) time += rational(part, 1);
    gps.push_back({7, kRationalType, static_cast<uint32_t>(times.gps_time.size()), time});
  }
  if (!times.gps_date.empty()) gps.push_back(AsciiTag(0x1d, times.gps_date));
  std::vector<TiffTag> photo;
  if (!times.taken.empty()) photo.push_back(AsciiTag(0x9003, times.taken));
  if (!times.offset.empty()) photo.push_back(AsciiTag(0x9011, times.offset));
  return WithExif(jpeg, gps, photo);
}

}  // namespace freelsd
