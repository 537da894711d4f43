#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include <archive.h>
#include <archive_entry.h>

#include "api/export/map/map_picture.h"
#include "api/export/map/outline.h"
#include "api/export/png.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

constexpr double kMaxPicturePx = 2048.0;
// Decimals of a degree: 1e-9 is a tenth of a millimetre.
constexpr int kDegreeDecimals = 9;
// 1 January 2000: the same map gives the same bytes. Zip knows no time before 1980.
constexpr time_t kFileTime = 946728000;

// A picture with lines of equal latitude and equal longitude.
struct Overlay {
  double west_deg, east_deg, south_deg, north_deg;
  cv::Size size;
  double pixel_size_m;
};

Overlay OverlayOf(const WorldBox& extent, double cell_size_m, const LocalFrame& local_frame) {
  CheckExtent(extent);
  const std::vector<GeoPoint> outline = OutlineOf(extent, local_frame);
  const auto [west, east] =
      std::minmax_element(outline.begin(), outline.end(), [](const GeoPoint& a, const GeoPoint& b) {
        return a.longitude_deg < b.longitude_deg;
      });
  const auto [south, north] =
      std::minmax_element(outline.begin(), outline.end(), [](const GeoPoint& a, const GeoPoint& b) {
        return a.latitude_deg < b.latitude_deg;
      });
  const Eigen::Vector2d size_m = extent.max_in_world - extent.min_in_world;
  const double pixel_size_m = std::max(cell_size_m, size_m.maxCoeff() / kMaxPicturePx);
  const Eigen::Array2d size_px = (size_m.array() / pixel_size_m).ceil().max(1.0).min(kMaxPicturePx);
  return {west->longitude_deg,
          east->longitude_deg,
          south->latitude_deg,
          north->latitude_deg,
          cv::Size(static_cast<int>(size_px.x()), static_cast<int>(size_px.y())),
          pixel_size_m};
}

PixelPlaces PlacesOf(const Overlay& overlay, const LocalFrame& local_frame) {
  const double degrees_per_col = (overlay.east_deg - overlay.west_deg) / overlay.size.width;
  const double degrees_per_row = (overlay.north_deg - overlay.south_deg) / overlay.size.height;
  const auto geo = [=](const Eigen::Vector2d& position) {
    return GeoPoint{overlay.north_deg - degrees_per_row * position.y(),
                    overlay.west_deg + degrees_per_col * position.x(),
                    0.0};
  };
  return {{geo, overlay.pixel_size_m}, cv::Rect(cv::Point(0, 0), overlay.size), local_frame};
}

int CoarsestLevel(double finest_cell_size_m, int num_levels, double pixel_size_m) {
  int level = 0;
  while (level + 1 < num_levels && std::ldexp(finest_cell_size_m, level + 1) <= pixel_size_m) {
    ++level;
  }
  return level;
}

std::string KmlOf(const std::string& name, const Overlay& overlay) {
  const auto degrees = [](double value) { return FixedText(value, kDegreeDecimals); };
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n"
         "<GroundOverlay>\n"
         "<name>" +
         EscapeXml(OneLine(name)) +
         "</name>\n"
         "<Icon><href>map.png</href></Icon>\n"
         "<LatLonBox>"
         "<north>" +
         degrees(overlay.north_deg) +
         "</north>"
         "<south>" +
         degrees(overlay.south_deg) +
         "</south>"
         "<east>" +
         degrees(overlay.east_deg) +
         "</east>"
         "<west>" +
         degrees(overlay.west_deg) +
         "</west>"
         "</LatLonBox>\n"
         "</GroundOverlay>\n"
         "</kml>\n";
}

struct ArchiveFreer {
  void operator()(archive* written) const { archive_write_free(written); }
};
struct EntryFreer {
  void operator()(archive_entry* entry) const { archive_entry_free(entry); }
};

void AddFile(archive* zip, const char* name, const std::string& bytes) {
  const std::unique_ptr<archive_entry, EntryFreer> entry(archive_entry_new());
  archive_entry_set_pathname(entry.get(), name);
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  archive_entry_set_mtime(entry.get(), kFileTime, 0);
  const bool is_written =
      archive_write_header(zip, entry.get()) == ARCHIVE_OK &&
      archive_write_data(zip, bytes.data(), bytes.size()) == static_cast<la_ssize_t>(bytes.size());
  if (!is_written) throw std::runtime_error(std::string("KMZ: ") + archive_error_string(zip));
}

// doc.kml comes first: programs take the first KML file.
std::string ZipOf(const std::string& kml, const std::string& png) {
  // Names, times and the directory at the end.
  constexpr size_t kMaxOverhead = 65536;
  std::string bytes(kml.size() + png.size() + kMaxOverhead, '\0');
  size_t size = 0;
  const std::unique_ptr<archive, ArchiveFreer> zip(archive_write_new());
  archive_write_set_format_zip(zip.get());
  // The picture is compressed.
  archive_write_set_options(zip.get(), "zip:compression=store");
  archive_write_set_bytes_in_last_block(zip.get(), 1);
  if (archive_write_open_memory(zip.get(), bytes.data(), bytes.size(), &size) != ARCHIVE_OK) {
    throw std::runtime_error(std::string("KMZ: ") + archive_error_string(zip.get()));
  }
  AddFile(zip.get(), "doc.kml", kml);
  AddFile(zip.get(), "map.png", png);
  if (archive_write_close(zip.get()) != ARCHIVE_OK) {
    throw std::runtime_error(std::string("KMZ: ") + archive_error_string(zip.get()));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::string MapKmz(const std::string& name,
                   const std::string& layer,
                   const MapSource& source,
                   const Scale& scale,
                   const LocalFrame& local_frame) {
  const MapLayer map_layer = ValueLayerOf(layer);
  CheckScale(scale);
  const Overlay overlay = OverlayOf(source.extent, source.finest_cell_size_m, local_frame);
  const PixelPlaces places = PlacesOf(overlay, local_frame);
  const int level =
      CoarsestLevel(source.finest_cell_size_m, source.num_levels, overlay.pixel_size_m);
  const std::vector<MapWindow> windows = source.windows_of(places.BoxInWorld(), level);
  const std::string png =
      map_layer == MapLayer::kElevation
          ? EncodePng(ElevationPicture(places, windows, scale, local_frame))
          : EncodePalettePng(IndicesOf(map_layer, places, windows, scale), PaletteOf(layer));
  return ZipOf(KmlOf(name, overlay), png);
}

std::string PhotoKmz(const std::string& name,
                     const PhotoSource& source,
                     const LocalFrame& local_frame) {
  const Overlay overlay = OverlayOf(source.extent, source.finest_pixel_size_m, local_frame);
  const PixelPlaces places = PlacesOf(overlay, local_frame);
  const int level =
      CoarsestLevel(source.finest_pixel_size_m, source.num_levels, overlay.pixel_size_m);
  const std::vector<PhotoWindow> windows = source.windows_of(places.BoxInWorld(), level);
  return ZipOf(KmlOf(name, overlay), EncodePng(PhotoPicture(places, windows)));
}

}  // namespace freelsd
