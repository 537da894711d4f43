#include <cstring>
#include <memory>
#include <stdexcept>

#include <geotiff/xtiffio.h>

#include "api/export/geotiff_tags.h"
#include "api/export/layers/layer_values.h"
#include "api/export/utm.h"

namespace freelsd {
namespace {

constexpr int kRowsPerStrip = 64;

// File in memory with the callbacks that libtiff needs.
struct Stream {
  std::string bytes;
  toff_t position = 0;
};

tmsize_t ReadStream(thandle_t handle, void* to, tmsize_t size) {
  Stream& stream = *static_cast<Stream*>(handle);
  if (stream.position >= stream.bytes.size()) return 0;
  const size_t count = std::min<size_t>(size, stream.bytes.size() - stream.position);
  std::memcpy(to, stream.bytes.data() + stream.position, count);
  stream.position += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t WriteStream(thandle_t handle, void* from, tmsize_t size) {
  Stream& stream = *static_cast<Stream*>(handle);
  const size_t end = stream.position + size;
  if (stream.bytes.size() < end) stream.bytes.resize(end);
  std::memcpy(stream.bytes.data() + stream.position, from, size);
  stream.position = end;
  return size;
}

toff_t SeekStream(thandle_t handle, toff_t offset, int origin) {
  Stream& stream = *static_cast<Stream*>(handle);
  if (origin == SEEK_CUR) offset += stream.position;
  if (origin == SEEK_END) offset += stream.bytes.size();
  return stream.position = offset;
}

int CloseStream(thandle_t) { return 0; }

toff_t SizeOfStream(thandle_t handle) { return static_cast<Stream*>(handle)->bytes.size(); }

struct TiffCloser {
  void operator()(TIFF* tiff) const { XTIFFClose(tiff); }
};

void WriteTags(TIFF* tiff, const cv::Mat1f& values) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, values.cols);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, values.rows);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kRowsPerStrip);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  WriteNoDataTag(tiff);
}

void WriteGeoreference(TIFF* tiff, const Eigen::Matrix<double, 2, 3>& m, const Utm& utm) {
  const double matrix[16] = {m(0, 0),
                             m(0, 1),
                             0.0,
                             m(0, 2),  //
                             m(1, 0),
                             m(1, 1),
                             0.0,
                             m(1, 2),  //
                             0.0,
                             0.0,
                             0.0,
                             0.0,  //
                             0.0,
                             0.0,
                             0.0,
                             1.0};
  TIFFSetField(tiff, TIFFTAG_GEOTRANSMATRIX, 16, matrix);
  WriteGeoKeys(tiff, utm.Epsg());
}

void AddAltitude(const Grid& grid, const LocalFrame& frame, cv::Mat1f& elevation) {
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      elevation(row, col) += static_cast<float>(AltitudeOfPlane(grid.CellCenter(row, col), frame));
    }
  }
}

}  // namespace

std::string LayerGeoTiff(const SiteMap& site_map,
                         const std::string& name,
                         const LocalFrame& local_frame) {
  cv::Mat1f values = LayerValues(site_map, name);
  const Grid& grid = site_map.map.grid;
  if (values.empty()) throw std::invalid_argument("layer = " + name + ": the map is empty");
  if (name == "elevation") AddAltitude(grid, local_frame, values);
  const Utm utm = ZoneOf(local_frame.origin());
  Stream stream;
  std::unique_ptr<TIFF, TiffCloser> tiff(XTIFFClientOpen("layer.tif",
                                                         "wl",
                                                         &stream,
                                                         ReadStream,
                                                         WriteStream,
                                                         SeekStream,
                                                         CloseStream,
                                                         SizeOfStream,
                                                         nullptr,
                                                         nullptr));
  if (!tiff) throw std::runtime_error("GeoTIFF: cannot be started");
  WriteTags(tiff.get(), values);
  WriteGeoreference(tiff.get(), UtmFromPixel(grid, utm, local_frame), utm);
  for (int row = 0; row < values.rows; ++row) {
    if (TIFFWriteScanline(tiff.get(), values[row], row, 0) != 1) {
      throw std::runtime_error("GeoTIFF: a row cannot be written");
    }
  }
  if (TIFFFlush(tiff.get()) != 1) throw std::runtime_error("GeoTIFF: cannot be finished");
  tiff.reset();
  return stream.bytes;
}

}  // namespace freelsd
