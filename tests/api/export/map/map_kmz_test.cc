#include <cmath>
#include <map>

#include <archive.h>
#include <archive_entry.h>
#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/export/color_ramp.h"
#include "api/export/map/map_layer.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

std::map<std::string, std::string> Unzipped(const std::string& bytes) {
  std::map<std::string, std::string> files;
  archive* zip = archive_read_new();
  archive_read_support_format_zip(zip);
  REQUIRE(archive_read_open_memory(zip, bytes.data(), bytes.size()) == ARCHIVE_OK);
  archive_entry* entry = nullptr;
  while (archive_read_next_header(zip, &entry) == ARCHIVE_OK) {
    std::string content(static_cast<size_t>(archive_entry_size(entry)), '\0');
    REQUIRE(archive_read_data(zip, content.data(), content.size()) ==
            static_cast<la_ssize_t>(content.size()));
    files[archive_entry_pathname(entry)] = content;
  }
  archive_read_free(zip);
  return files;
}

double NumberIn(const std::string& kml, const std::string& tag) {
  return std::stod(kml.substr(kml.find("<" + tag + ">") + tag.size() + 2));
}

TEST_CASE("map: a KMZ holds a document and a picture that lies where its box says") {
  const MapSource source = TwoWindows();
  const auto windows = source.windows_of({}, 0);
  const CellFinder finder(windows);
  const cv::Vec4b hazard(kHazardColor[2], kHazardColor[1], kHazardColor[0], 255);
  for (const LocalFrame& frame : {FrameAt(47.4, 8.55), FrameAt(-60.0, 179.9999)}) {
    const std::string kmz = MapKmz("field <1> & more", "hazard", source, {0.0, 2.0}, frame);
    CHECK(kmz == MapKmz("field <1> & more", "hazard", source, {0.0, 2.0}, frame));
    const auto files = Unzipped(kmz);
    REQUIRE(files.size() == 2);
    const std::string& kml = files.at("doc.kml");
    CHECK(kml.find("<name>field &lt;1&gt; &amp; more</name>") != std::string::npos);
    CHECK(kml.find("<href>map.png</href>") != std::string::npos);
    const std::string& png = files.at("map.png");
    const cv::Mat4b picture =
        cv::imdecode(std::vector<uint8_t>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
    const double west = NumberIn(kml, "west"), east = NumberIn(kml, "east");
    const double south = NumberIn(kml, "south"), north = NumberIn(kml, "north");
    CHECK(west < east);
    CHECK(south < north);
    for (int y = -220; y < 300; ++y) {
      for (int x = -300; x < 340; ++x) {
        const WindowCell cell = finder.At({x + 0.5, y + 0.5});
        if (!cell.window) continue;
        if (cell.window->site_map.layers.hazard(cell.row, cell.col) != kHazard) continue;
        GeoPoint geo = frame.GeoFromWorld({x + 0.5, y + 0.5, 0.0});
        if (geo.longitude_deg < west) geo.longitude_deg += 360.0;
        const double col = (geo.longitude_deg - west) / (east - west) * picture.cols;
        const double row = (north - geo.latitude_deg) / (north - south) * picture.rows;
        REQUIRE(picture(static_cast<int>(row), static_cast<int>(col)) == hazard);
      }
    }
  }
}

TEST_CASE("map: a KMZ's picture has at most 2048 pixels a side") {
  const LocalFrame frame = FrameAt(47.4, 8.55);
  PhotoWindow photo{{{0.0, 250.0}, 0.1, 2500, 1000},
                    cv::Mat4b(2500, 1000, cv::Vec4b(1, 2, 3, 255))};
  const PhotoSource source{
      BoxOf(photo.grid), 0.1, 1, SourceOf(std::vector<std::vector<PhotoWindow>>{{photo}}), {}};
  const auto files = Unzipped(PhotoKmz("photo", source, frame));
  const std::string& png = files.at("map.png");
  const cv::Mat4b picture =
      cv::imdecode(std::vector<uint8_t>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
  CHECK(picture.rows == 2048);
  CHECK(picture.cols == 820);
  CHECK(picture(1000, 400) == cv::Vec4b(1, 2, 3, 255));
}

}  // namespace
}  // namespace freelsd
