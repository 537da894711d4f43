#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include <geotiff/xtiffio.h>

#include "api/api.h"
#include "api/export/geotiff_tags.h"
#include "api/export/map/map_picture.h"
#include "api/export/map/outline.h"
#include "api/export/text.h"
#include "api/export/utm.h"

namespace freelsd {
namespace {

constexpr int kTilePx = 256;
// Tiles that are drawn together: more need more memory, fewer read more windows twice.
constexpr int kTilesPerBlock = 8;
// Two thirds of the time of zlib's default and a few per cent more bytes.
constexpr int kDeflateLevel = 4;
// By this, tiles around a part count as tiles that meet it: coarse cells reach over its edge.
constexpr double kPartMarginPx = 3.0;
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
  // Eastings and northings of the parts of the map.
  std::vector<Eigen::AlignedBox2d> parts;
};

Eigen::AlignedBox2d UtmBoxOf(const Utm& utm, const WorldBox& box, const LocalFrame& local_frame) {
  Eigen::AlignedBox2d around;
  for (const GeoPoint& place : OutlineOf(box, local_frame)) around.extend(UtmFromGeo(utm, place));
  return around;
}

template <typename Source>
UtmGrid UtmGridOf(const Source& source, double pixel_size_m, const LocalFrame& local_frame) {
  const int num_levels = source.num_levels;
  CheckExtent(source.extent);
  if (!(std::isfinite(pixel_size_m) && pixel_size_m > 0.0) || num_levels < 1) {
    throw std::invalid_argument("map: a positive cell size and at least one level are needed");
  }
  UtmGrid grid;
  grid.utm = ZoneOf(local_frame.origin());
  grid.pixel_size_m = pixel_size_m;
  const Eigen::AlignedBox2d box = UtmBoxOf(grid.utm, source.extent, local_frame);
  for (const WorldBox& part : source.parts) {
    grid.parts.push_back(UtmBoxOf(grid.utm, part, local_frame));
  }
  if (grid.parts.empty()) grid.parts.push_back(box);
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

// Which tiles of a level meet a part: 1, others 0.
cv::Mat1b TilesWithParts(const UtmGrid& grid, int level) {
  const auto num_tiles = [level](int size_px) {
    return static_cast<int>(std::ceil(std::ldexp(size_px, -level) / kTilePx));
  };
  const double tile_m = std::ldexp(grid.pixel_size_m, level) * kTilePx;
  const Eigen::Array2d margin = Eigen::Array2d::Constant(kPartMarginPx / kTilePx);
  cv::Mat1b tiles = cv::Mat1b::zeros(num_tiles(grid.num_rows), num_tiles(grid.num_cols));
  for (const Eigen::AlignedBox2d& part : grid.parts) {
    const Eigen::Array2d north_west(part.min().x() - grid.north_west.x(),
                                    grid.north_west.y() - part.max().y());
    const Eigen::Array2d low = (north_west / tile_m - margin).floor();
    const Eigen::Array2d high = ((north_west + part.sizes().array()) / tile_m + margin).ceil();
    const cv::Rect met(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                       cv::Point(static_cast<int>(high.x()), static_cast<int>(high.y())));
    tiles(met & cv::Rect(cv::Point(0, 0), tiles.size())).setTo(1);
  }
  return tiles;
}

void RefuseAbove(double limit, double observed, const char* unit) {
  if (observed <= limit) return;
  ApiError error("TooLarge",
                 "the GeoTIFF of this layer would have " + FixedText(observed * 1e-6, 0) +
                     " million " + unit + "; at most " + FixedText(limit * 1e-6, 0) +
                     " million are possible");
  error.limit = limit;
  error.observed = observed;
  throw error;
}

void CheckSize(const UtmGrid& grid, const GeoTiffOptions& options) {
  const double num_pixels = 1.0 * grid.num_cols * grid.num_rows;
  RefuseAbove(options.max_num_tiles, num_pixels / (kTilePx * kTilePx), "tiles");
  const double num_drawn = 1.0 * cv::countNonZero(TilesWithParts(grid, 0)) * kTilePx * kTilePx;
  RefuseAbove(options.max_num_pixels, num_drawn, "pixels");
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

// Blocks of tiles that meet a part; each is one row of neighbours.
std::vector<cv::Rect> BlocksOf(const cv::Mat1b& tiles) {
  std::vector<cv::Rect> blocks;
  for (int row = 0; row < tiles.rows; ++row) {
    for (int col = 0; col < tiles.cols; ++col) {
      if (tiles(row, col) == 0) continue;
      const bool is_next = !blocks.empty() && blocks.back().y == row &&
                           blocks.back().br().x == col && blocks.back().width < kTilesPerBlock;
      if (is_next) {
        ++blocks.back().width;
      } else {
        blocks.emplace_back(col, row, 1, 1);
      }
    }
  }
  return blocks;
}

// `draw(places, level)` gives the pixels of a block: 32-bit floats or RGBA.
template <typename Draw>
void WriteFile(const std::string& path,
               const UtmGrid& grid,
               PixelKind kind,
               const LocalFrame& local_frame,
               const GeoTiffOptions& options,
               Draw draw) {
  CheckSize(grid, options);
  const TiffFile tiff = OpenFile(path, grid);
  for (int level = 0; level <= grid.num_overviews; ++level) {
    WriteTags(tiff.get(), grid, level, kind);
    const cv::Rect all(0, 0, grid.num_cols >> level, grid.num_rows >> level);
    const PictureFrame picture = FrameOf(grid, level);
    for (const cv::Rect& block : BlocksOf(TilesWithParts(grid, level))) {
      const cv::Rect box = cv::Rect(block.tl() * kTilePx, block.size() * kTilePx) & all;
      WriteBlock(tiff.get(), draw(PixelPlaces(picture, box, local_frame), level), box.tl());
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
                       const LocalFrame& local_frame,
                       const GeoTiffOptions& options) {
  const MapLayer map_layer = ValueLayerOf(layer);
  const UtmGrid grid = UtmGridOf(source, source.finest_cell_size_m, local_frame);
  const auto draw = [&](const PixelPlaces& places, int level) -> cv::Mat {
    return ValuesOf(map_layer, places, source.windows_of(places.BoxInWorld(), level), local_frame);
  };
  WriteFile(path, grid, PixelKind::kFloat, local_frame, options, draw);
}

void WritePhotoGeoTiff(const std::string& path,
                       const PhotoSource& source,
                       const LocalFrame& local_frame,
                       const GeoTiffOptions& options) {
  const UtmGrid grid = UtmGridOf(source, source.finest_pixel_size_m, local_frame);
  const auto draw = [&](const PixelPlaces& places, int level) -> cv::Mat {
    cv::Mat4b picture = PhotoPicture(places, source.windows_of(places.BoxInWorld(), level));
    for (cv::Vec4b& pixel : picture) std::swap(pixel[0], pixel[2]);
    return picture;
  };
  WriteFile(path, grid, PixelKind::kRgba, local_frame, options, draw);
}

}  // namespace freelsd
