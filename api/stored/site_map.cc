// The stored form of a site's map:
//   "FLSM", version (u32), size (u64) and CRC-32 (u32) of the content, then the content deflated.
// Content: grid (3 doubles, 2 int32), deviations of position and tilt (2 doubles), eight float
// rasters and one of bytes, each row-major. The floats of a raster are stored byte plane by byte
// plane, which deflates to about two thirds.
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <zlib.h>

#include "api/stored/stored.h"

namespace freelsd {
namespace {

static_assert(std::endian::native == std::endian::little, "stored maps are little-endian");

constexpr char kMagic[4] = {'F', 'L', 'S', 'M'};
constexpr uint32_t kVersion = 1;
// Version of a map whose photographs were compared.
constexpr uint32_t kComparedVersion = 2;
// Fast: noisy floats gain little from searching longer.
constexpr int kDeflateLevel = 3;
constexpr uint64_t kHeadBytes = 5 * sizeof(double) + 2 * sizeof(int32_t);
constexpr uint64_t kNumFloatRasters = 8;
constexpr uint64_t kCellBytes = kNumFloatRasters * sizeof(float) + 1;
// Deflate shrinks at most 1032 : 1, so a larger stated size is wrong.
constexpr uint64_t kMaxDeflateRatio = 1040;

struct Header {
  char magic[4];
  uint32_t version;
  uint64_t content_size;
  uint32_t content_crc;
  uint32_t reserved;
};

[[noreturn]] void Refuse(const std::string& reason) {
  throw DamagedMap("stored site map: " + reason);
}

uint32_t Checksum(const std::string& bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

class Writer {
 public:
  template <typename T>
  void Append(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }

  void AppendPlanes(const cv::Mat1f& raster) {
    const cv::Mat1f whole = raster.isContinuous() ? raster : raster.clone();
    const size_t num_cells = whole.total(), start = bytes_.size();
    const char* from = reinterpret_cast<const char*>(whole.data);
    bytes_.resize(start + num_cells * sizeof(float));
    for (size_t plane = 0; plane < sizeof(float); ++plane) {
      char* to = bytes_.data() + start + plane * num_cells;
      for (size_t i = 0; i < num_cells; ++i) to[i] = from[i * sizeof(float) + plane];
    }
  }

  void AppendBytes(const cv::Mat1b& raster) {
    for (int row = 0; row < raster.rows; ++row) {
      bytes_.append(reinterpret_cast<const char*>(raster[row]), raster.cols);
    }
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// The caller must check the length of the content.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}

  template <typename T>
  T Take() {
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  cv::Mat1f TakePlanes(const Grid& grid) {
    cv::Mat1f raster(grid.num_rows, grid.num_cols);
    const size_t num_cells = raster.total();
    char* to = reinterpret_cast<char*>(raster.data);
    for (size_t plane = 0; plane < sizeof(float); ++plane) {
      const char* from = bytes_.data() + position_ + plane * num_cells;
      for (size_t i = 0; i < num_cells; ++i) to[i * sizeof(float) + plane] = from[i];
    }
    position_ += num_cells * sizeof(float);
    return raster;
  }

  cv::Mat1b TakeBytes(const Grid& grid) {
    cv::Mat1b raster(grid.num_rows, grid.num_cols);
    if (!raster.empty()) std::memcpy(raster.data, bytes_.data() + position_, raster.total());
    position_ += raster.total();
    return raster;
  }

 private:
  const std::string& bytes_;
  size_t position_ = 0;
};

std::string Deflate(const std::string& content) {
  uLongf size = compressBound(content.size());
  std::string deflated(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(deflated.data()),
                               &size,
                               reinterpret_cast<const Bytef*>(content.data()),
                               content.size(),
                               kDeflateLevel);
  if (status != Z_OK) throw std::runtime_error("site map: zlib could not deflate it");
  deflated.resize(size);
  return deflated;
}

std::string Inflate(const char* bytes, size_t num_bytes, uint64_t content_size) {
  std::string content(content_size, '\0');
  uLongf size = content_size;
  const int status = uncompress(reinterpret_cast<Bytef*>(content.data()),
                                &size,
                                reinterpret_cast<const Bytef*>(bytes),
                                num_bytes);
  if (status != Z_OK || size != content_size) Refuse("does not inflate");
  return content;
}

Header ReadHeader(const std::string& bytes) {
  Header header;
  if (bytes.size() < sizeof(Header)) Refuse("shorter than its header");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) Refuse("is none");
  if (header.version != kVersion && header.version != kComparedVersion) {
    throw std::runtime_error("stored site map: version " + std::to_string(header.version));
  }
  const uint64_t num_deflated = bytes.size() - sizeof(Header);
  const uint64_t max_size = std::min(kHeadBytes + kLimits.max_num_map_cells * kCellBytes,
                                     kHeadBytes + num_deflated * kMaxDeflateRatio);
  if (header.content_size < kHeadBytes || header.content_size > max_size) {
    Refuse("its size is impossible");
  }
  return header;
}

Grid ReadGrid(Reader& reader, uint64_t content_size) {
  Grid grid;
  grid.north_west_in_world.x() = reader.Take<double>();
  grid.north_west_in_world.y() = reader.Take<double>();
  grid.cell_size_m = reader.Take<double>();
  grid.num_rows = reader.Take<int32_t>();
  grid.num_cols = reader.Take<int32_t>();
  const bool is_sane = grid.north_west_in_world.allFinite() && std::isfinite(grid.cell_size_m) &&
                       grid.cell_size_m > 0.0 && grid.num_rows >= 0 && grid.num_cols >= 0;
  if (!is_sane) Refuse("its grid is impossible");
  const uint64_t num_cells = static_cast<uint64_t>(grid.num_rows) * grid.num_cols;
  if (num_cells > kLimits.max_num_map_cells ||
      kHeadBytes + num_cells * kCellBytes != content_size) {
    Refuse("its grid and its size do not match");
  }
  return grid;
}

}  // namespace

std::string SerializeSiteMap(const SiteMap& site_map) {
  const auto& [map, layers] = site_map;
  Writer writer;
  writer.Append(map.grid.north_west_in_world.x());
  writer.Append(map.grid.north_west_in_world.y());
  writer.Append(map.grid.cell_size_m);
  writer.Append<int32_t>(map.grid.num_rows);
  writer.Append<int32_t>(map.grid.num_cols);
  writer.Append(map.position_sd_m);
  writer.Append(map.tilt_sd_deg);
  for (const cv::Mat1f& raster : {map.elevation,
                                  map.upper,
                                  map.standard_deviation,
                                  map.num_points,
                                  layers.slope,
                                  layers.roughness,
                                  layers.grass,
                                  layers.distance}) {
    if (raster.rows != map.grid.num_rows || raster.cols != map.grid.num_cols) {
      throw std::invalid_argument("site map: a layer is not of the grid's size");
    }
    writer.AppendPlanes(raster);
  }
  writer.AppendBytes(layers.hazard);
  const uint32_t version = map.is_compared ? kComparedVersion : kVersion;
  Header header{{}, version, writer.bytes().size(), Checksum(writer.bytes()), 0};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  return std::string(reinterpret_cast<const char*>(&header), sizeof(Header)) +
         Deflate(writer.bytes());
}

SiteMap DeserializeSiteMap(const std::string& bytes) {
  const Header header = ReadHeader(bytes);
  const std::string content =
      Inflate(bytes.data() + sizeof(Header), bytes.size() - sizeof(Header), header.content_size);
  if (Checksum(content) != header.content_crc) Refuse("its checksum does not match");
  Reader reader(content);
  SiteMap site_map;
  auto& [map, layers] = site_map;
  map.grid = layers.grid = ReadGrid(reader, header.content_size);
  map.position_sd_m = reader.Take<double>();
  map.tilt_sd_deg = reader.Take<double>();
  map.is_compared = header.version == kComparedVersion;
  if (!(map.position_sd_m >= 0.0 && map.tilt_sd_deg >= 0.0)) Refuse("a deviation below 0");
  for (cv::Mat1f* raster : {&map.elevation,
                            &map.upper,
                            &map.standard_deviation,
                            &map.num_points,
                            &layers.slope,
                            &layers.roughness,
                            &layers.grass,
                            &layers.distance}) {
    *raster = reader.TakePlanes(map.grid);
  }
  layers.hazard = reader.TakeBytes(map.grid);
  for (const uint8_t value : layers.hazard) {
    if (value > kUnseen) Refuse("an invalid hazard");
  }
  return site_map;
}

}  // namespace freelsd
