#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include <geotiff/xtiffio.h>

#include "api/export/geotiff_tags.h"
#include "api/export/map/map_picture.h"
#include "api/export/map/outline.h"
#include "api/export/utm.h"

namespace freelsd {
namespace {

constexpr int kTilePx = 256;
// Tiles that are drawn together: more need more memory, fewer read more windows twice.
constexpr int kTilesPerBlock = 8;
// Two thirds of the time of zlib's default and a few per cent more bytes.
constexpr int kDeflateLevel = 4;
// Above this size of all pixels, offsets need 64 bits.
constexpr double kMaxClassicBytes = 3.5e9;

struct TiffCloser {
  void operator()(TIFF* tiff) const { XTIFFClose(tiff); }
};
using TiffFile = std::unique_ptr<TIFF, TiffCloser>;

enum class PixelKind { kFloat, kRgba };

// Where the pixels of a file lie. The corner is at a multiple of the coarsest pixels, and every
// overview divides the size without a rest, so that programs compute the right place of its pixels.
struct UtmGrid {
  Utm utm;
  Eigen::Vector2d north_west;  // easting, northing
  double pixel_size_m = 1.0;
  int num_cols = 0;
  int num_rows = 0;
  int num_overviews = 0;
};

UtmGrid UtmGridOf(const WorldBox& extent,
                  double pixel_size_m,
                  int num_levels,
                  const LocalFrame& local_frame) {
  CheckExtent(extent);
  if (!(std::isfinite(pixel_size_m) && pixel_size_m > 0.0) || num_levels < 1) {
    throw std::invalid_argument("map: a positive cell size and at least one level are needed");
  }
  UtmGrid grid;
  grid.utm = ZoneOf(local_frame.origin());
  grid.pixel_size_m = pixel_size_m;
  Eigen::AlignedBox2d box;
  for (const GeoPoint& place : OutlineOf(extent, local_frame)) {
    box.extend(UtmFromGeo(grid.utm, place));
  }
  const double size_px = box.sizes().maxCoeff() / pixel_size_m;
  while (grid.num_overviews + 1 < num_levels &&
         std::ldexp(size_px, -grid.num_overviews) > kTilePx) {
    ++grid.num_overviews;
  }
  const double coarsest_m = std::ldexp(pixel_size_m, grid.num_overviews);
  const Eigen::Array2d low = (box.min().array() / coarsest_m).floor();
  const Eigen::Array2d high = (box.max().array() / coarsest_m).ceil();
  grid.north_west = Eigen::Vector2d(low.x(), high.y()) * coarsest_m;
  const Eigen::Array2d size = (high - low) * std::ldexp(1.0, grid.num_overviews);
  grid.num_cols = static_cast<int>(size.x());
  grid.num_rows = static_cast<int>(size.y());
  return grid;
}

TiffFile OpenFile(const std::string& path, const UtmGrid& grid) {
  const double num_bytes = 4.0 * grid.num_cols * grid.num_rows;
  TiffFile tiff(XTIFFOpen(path.c_str(), num_bytes > kMaxClassicBytes ? "wl8" : "wl"));
  if (!tiff) throw std::runtime_error("GeoTIFF: " + path + " cannot be opened for writing");
  return tiff;
}

void WriteKind(TIFF* tiff, PixelKind kind) {
  if (kind == PixelKind::kFloat) {
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
    WriteNoDataTag(tiff);
    return;
  }
  const uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 4);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
}

void WriteTags(TIFF* tiff, const UtmGrid& grid, int level, PixelKind kind) {
  TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, level == 0 ? 0 : FILETYPE_REDUCEDIMAGE);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, grid.num_cols >> level);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, grid.num_rows >> level);
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kTilePx);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, kTilePx);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, kDeflateLevel);
  WriteKind(tiff, kind);
  if (level > 0) return;
  const double size[3] = {grid.pixel_size_m, grid.pixel_size_m, 0.0};
  const double tie_point[6] = {0.0, 0.0, 0.0, grid.north_west.x(), grid.north_west.y(), 0.0};
  TIFFSetField(tiff, TIFFTAG_GEOPIXELSCALE, 3, size);
  TIFFSetField(tiff, TIFFTAG_GEOTIEPOINTS, 6, tie_point);
  WriteGeoKeys(tiff, grid.utm.Epsg());
}

PictureFrame FrameOf(const UtmGrid& grid, int level) {
  const double pixel_size_m = std::ldexp(grid.pixel_size_m, level);
  return {[=](const Eigen::Vector2d& position) {
            return GeoFromUtm(
                grid.utm,
                grid.north_west + pixel_size_m * Eigen::Vector2d(position.x(), -position.y()));
          },
          pixel_size_m};
}

// Pixels of four bytes. The block begins at `first_px` of the picture.
void WriteBlock(TIFF* tiff, const cv::Mat& block, const cv::Point& first_px) {
  for (int col = 0; col < block.cols; col += kTilePx) {
    cv::Mat tile = cv::Mat::zeros(kTilePx, kTilePx, block.type());
    const cv::Rect part(col, 0, std::min(kTilePx, block.cols - col), block.rows);
    block(part).copyTo(tile(cv::Rect(cv::Point(0, 0), part.size())));
    const auto x = static_cast<uint32_t>(first_px.x + col), y = static_cast<uint32_t>(first_px.y);
    if (TIFFWriteTile(tiff, tile.data, x, y, 0, 0) < 0) {
      throw std::runtime_error("GeoTIFF: a tile cannot be written");
    }
  }
}

// `draw(places, level)` gives the pixels of a block: 32-bit floats or RGBA.
template <typename Draw>
void WriteFile(const std::string& path,
               const UtmGrid& grid,
               PixelKind kind,
               const LocalFrame& local_frame,
               Draw draw) {
  const TiffFile tiff = OpenFile(path, grid);
  for (int level = 0; level <= grid.num_overviews; ++level) {
    WriteTags(tiff.get(), grid, level, kind);
    const cv::Rect all(0, 0, grid.num_cols >> level, grid.num_rows >> level);
    const PictureFrame picture = FrameOf(grid, level);
    for (int row = 0; row < all.height; row += kTilePx) {
      for (int col = 0; col < all.width; col += kTilesPerBlock * kTilePx) {
        const cv::Rect box = cv::Rect(col, row, kTilesPerBlock * kTilePx, kTilePx) & all;
        WriteBlock(tiff.get(), draw(PixelPlaces(picture, box, local_frame), level), box.tl());
      }
    }
    if (TIFFWriteDirectory(tiff.get()) != 1) {
      throw std::runtime_error("GeoTIFF: a directory cannot be written");
    }
  }
}

}  // namespace

void WriteLayerGeoTiff(const std::string& path,
                       const std::string& layer,
                       const MapSource& source,
                       const LocalFrame& local_frame) {
  const MapLayer map_layer = ValueLayerOf(layer);
  const UtmGrid grid =
      UtmGridOf(source.extent, source.finest_cell_size_m, source.num_levels, local_frame);
  const auto draw = [&](const PixelPlaces& places, int level) -> cv::Mat {
    return ValuesOf(map_layer, places, source.windows_of(places.BoxInWorld(), level), local_frame);
  };
  WriteFile(path, grid, PixelKind::kFloat, local_frame, draw);
}

void WritePhotoGeoTiff(const std::string& path,
                       const PhotoSource& source,
                       const LocalFrame& local_frame) {
  const UtmGrid grid =
      UtmGridOf(source.extent, source.finest_pixel_size_m, source.num_levels, local_frame);
  const auto draw = [&](const PixelPlaces& places, int level) -> cv::Mat {
    cv::Mat4b picture = PhotoPicture(places, source.windows_of(places.BoxInWorld(), level));
    for (cv::Vec4b& pixel : picture) std::swap(pixel[0], pixel[2]);
    return picture;
  };
  WriteFile(path, grid, PixelKind::kRgba, local_frame, draw);
}

}  // namespace freelsd
