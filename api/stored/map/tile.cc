// The stored form of a tile:
//   "FLMT", version (u32), then three parts, each with its size (u32), the size of its deflated
//   bytes (u32) and its CRC-32 (u32): the rasters for planning, those only for display, and cues.
// A raster is a number for each cell, row by row: a count of steps (MapSteps), 0xFFFF where
// unknown. Each number is stored as the difference from the one to the west, or, in the first
// column, from the one to the north. All low bytes of a raster come before its high bytes: this
// halves the size. Each cue is the size of its name (u8), the name, and a byte for each cell.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <stdexcept>

#include <zlib.h>

#include "api/stored/map/map.h"

namespace freelsd {
namespace {

static_assert(std::endian::native == std::endian::little, "stored tiles are little-endian");

constexpr char kMagic[4] = {'F', 'L', 'M', 'T'};
constexpr uint32_t kVersion = 3;
// Has no kinds of ground.
constexpr uint32_t kVersionWithoutKinds = 2;
constexpr size_t kMaxNumCues = 64;
constexpr int kDeflateLevel = 6;
constexpr size_t kNumCells = size_t{kTileCells} * kTileCells;
constexpr uint16_t kUnknown = 0xFFFF;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kDistanceStepM = 1.0f / 16.0f;
// Elevation, upper, deviation, number of points, slope, roughness, grass; then the kind, a byte.
constexpr size_t kNumPlanningRasters = 7;
constexpr size_t kPlanningStepsBytes = sizeof(int32_t) + kNumPlanningRasters * kNumCells * 2;
constexpr size_t kPlanningBytes = kPlanningStepsBytes + kNumCells;
// Hazard, coverage, distance.
constexpr size_t kDisplayBytes = kNumCells * (1 + 1 + 2);

struct PartHead {
  uint32_t size = 0;
  uint32_t deflated_size = 0;
  uint32_t crc = 0;
};

[[noreturn]] void Refuse(const std::string& reason) {
  throw DamagedMap("stored map tile: " + reason);
}

uint32_t Checksum(const std::string& bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

template <typename T>
void Append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

using Steps = std::vector<uint16_t>;

uint16_t Before(const Steps& steps, size_t i) {
  if (i % kTileCells != 0) return steps[i - 1];
  return i == 0 ? uint16_t{0} : steps[i - kTileCells];
}

void AppendSteps(std::string& bytes, const Steps& steps) {
  const size_t start = bytes.size();
  bytes.resize(start + 2 * steps.size());
  for (size_t i = 0; i < steps.size(); ++i) {
    const auto difference = static_cast<uint16_t>(steps[i] - Before(steps, i));
    bytes[start + i] = static_cast<char>(difference & 0xFF);
    bytes[start + steps.size() + i] = static_cast<char>(difference >> 8);
  }
}

Steps ReadSteps(const std::string& bytes, size_t start) {
  Steps steps(kNumCells);
  const auto* const low = reinterpret_cast<const uint8_t*>(bytes.data() + start);
  const uint8_t* const high = low + kNumCells;
  uint16_t first_of_row = 0;
  for (size_t row = 0; row < kNumCells; row += kTileCells) {
    uint16_t value = first_of_row;
    for (size_t i = row; i < row + kTileCells; ++i) {
      value = static_cast<uint16_t>(value + (low[i] | (high[i] << 8)));
      steps[i] = value;
    }
    first_of_row = steps[row];
  }
  return steps;
}

// A value that needs more steps is unknown.
uint16_t StepsOf(double num_steps) {
  if (!(num_steps >= 0.0 && num_steps <= MapSteps::kMaxNumSteps)) return kUnknown;
  return static_cast<uint16_t>(std::lround(num_steps));
}

Steps StepsOf(const cv::Mat1f& raster, float step) {
  Steps steps(kNumCells);
  std::transform(raster.begin(), raster.end(), steps.begin(), [step](float value) {
    return StepsOf(value / step);
  });
  return steps;
}

cv::Mat1f ValuesOf(const Steps& steps, float step) {
  cv::Mat1f raster(kTileCells, kTileCells);
  std::transform(steps.begin(), steps.end(), raster.ptr<float>(), [step](uint16_t count) {
    return count == kUnknown ? kNaN : static_cast<float>(count) * step;
  });
  return raster;
}

// The height that all steps of the tile count from, in steps.
int32_t BaseOf(const ElevationMap& map) {
  float lowest = std::numeric_limits<float>::infinity();
  for (const cv::Mat1f& raster : {map.elevation, map.upper}) {
    for (const float height : raster) {
      if (height < lowest) lowest = height;
    }
  }
  return std::isfinite(lowest) ? static_cast<int32_t>(std::floor(lowest / MapSteps::kHeightM)) : 0;
}

double StepsAbove(float height, int32_t base) {
  return static_cast<double>(height) / MapSteps::kHeightM - base;
}

// From the base where the elevation is unknown, else from the elevation.
Steps UpperSteps(const ElevationMap& map, const Steps& elevation, int32_t base) {
  Steps steps(kNumCells);
  auto upper = map.upper.begin();
  for (size_t i = 0; i < kNumCells; ++i, ++upper) {
    const double above = StepsAbove(*upper, base);
    const double from = elevation[i] == kUnknown ? 0.0 : elevation[i];
    steps[i] = std::isnan(*upper)
                   ? kUnknown
                   : StepsOf(std::clamp(above - from, 0.0, double{MapSteps::kMaxNumSteps}));
  }
  return steps;
}

void AppendPart(std::string& bytes, const std::string& content) {
  uLongf size = compressBound(content.size());
  std::string deflated(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(deflated.data()),
                               &size,
                               reinterpret_cast<const Bytef*>(content.data()),
                               content.size(),
                               kDeflateLevel);
  if (status != Z_OK) throw std::runtime_error("map tile: zlib could not deflate it");
  Append(
      bytes,
      PartHead{
          static_cast<uint32_t>(content.size()), static_cast<uint32_t>(size), Checksum(content)});
  bytes.append(deflated, 0, size);
}

// Reads the part at `position`, and moves the position behind it.
std::string ReadPart(const std::string& bytes,
                     const std::function<bool(size_t)>& is_possible_size,
                     size_t& position) {
  PartHead head;
  if (bytes.size() < position + sizeof(head)) Refuse("is cut short");
  std::memcpy(&head, bytes.data() + position, sizeof(head));
  position += sizeof(head);
  if (!is_possible_size(head.size)) Refuse("a part has an impossible size");
  if (bytes.size() - position < head.deflated_size) Refuse("is cut short");
  std::string content(head.size, '\0');
  uLongf size = head.size;
  const int status = uncompress(reinterpret_cast<Bytef*>(content.data()),
                                &size,
                                reinterpret_cast<const Bytef*>(bytes.data() + position),
                                head.deflated_size);
  if (status != Z_OK || size != head.size) Refuse("does not inflate");
  if (Checksum(content) != head.crc) Refuse("its checksum is wrong");
  position += head.deflated_size;
  return content;
}

void AppendBytes(std::string& content, const cv::Mat1b& raster) {
  if (raster.empty()) {
    content.append(kNumCells, '\0');
    return;
  }
  for (int row = 0; row < raster.rows; ++row) {
    content.append(reinterpret_cast<const char*>(raster[row]), static_cast<size_t>(raster.cols));
  }
}

std::string PlanningPart(const SiteMap& ground) {
  const auto& [map, layers] = ground;
  const int32_t base = BaseOf(map);
  Steps elevation(kNumCells);
  std::transform(
      map.elevation.begin(), map.elevation.end(), elevation.begin(), [base](float height) {
        return StepsOf(StepsAbove(height, base));
      });
  std::string content;
  content.reserve(kPlanningBytes);
  Append(content, base);
  AppendSteps(content, elevation);
  AppendSteps(content, UpperSteps(map, elevation, base));
  AppendSteps(content, StepsOf(map.standard_deviation, MapSteps::kHeightM));
  AppendSteps(content, StepsOf(map.num_points, 1.0f));
  AppendSteps(content, StepsOf(layers.slope, MapSteps::kSlope));
  AppendSteps(content, StepsOf(layers.roughness, MapSteps::kRoughnessM));
  AppendSteps(content, StepsOf(layers.grass, MapSteps::kGrass));
  AppendBytes(content, layers.kind);
  return content;
}

std::string DisplayPart(const MapRasters& tile) {
  std::string content;
  content.reserve(kDisplayBytes);
  AppendBytes(content, tile.site_map.layers.hazard);
  AppendBytes(content, tile.coverage);
  Steps distance(kNumCells);
  std::transform(tile.site_map.layers.distance.begin(),
                 tile.site_map.layers.distance.end(),
                 distance.begin(),
                 [](float metres) {
                   const double num_steps = std::floor(metres / kDistanceStepM);
                   return StepsOf(std::min(num_steps, double{MapSteps::kMaxNumSteps}));
                 });
  AppendSteps(content, distance);
  return content;
}

std::string CuesPart(const std::vector<CueLayer>& cues) {
  std::string content;
  for (const CueLayer& cue : cues) {
    content.push_back(static_cast<char>(cue.name.size()));
    content.append(cue.name);
    for (int row = 0; row < cue.steps.rows; ++row) {
      content.append(reinterpret_cast<const char*>(cue.steps[row]),
                     static_cast<size_t>(cue.steps.cols));
    }
  }
  return content;
}

std::vector<CueLayer> ReadCues(const std::string& content) {
  std::vector<CueLayer> cues;
  for (size_t at = 0; at < content.size();) {
    const size_t name_size = static_cast<uint8_t>(content[at]);
    if (content.size() - at < 1 + name_size + kNumCells) Refuse("a cue is cut short");
    CueLayer cue{content.substr(at + 1, name_size), cv::Mat_<int8_t>(kTileCells, kTileCells)};
    std::memcpy(cue.steps.data, content.data() + at + 1 + name_size, kNumCells);
    at += 1 + name_size + kNumCells;
    cues.push_back(std::move(cue));
  }
  return cues;
}

void ReadPlanning(const std::string& content, SiteMap& ground) {
  auto& [map, layers] = ground;
  int32_t base = 0;
  std::memcpy(&base, content.data(), sizeof(base));
  const auto steps_of = [&content](size_t number) {
    return ReadSteps(content, sizeof(int32_t) + number * kNumCells * 2);
  };
  const Steps elevation = steps_of(0), upper = steps_of(1);
  const auto height = [base](int steps) {
    return static_cast<float>(base + steps) * MapSteps::kHeightM;
  };
  auto* const lower_cell = map.elevation.ptr<float>();
  auto* const upper_cell = map.upper.ptr<float>();
  for (size_t i = 0; i < kNumCells; ++i) {
    const bool is_known = elevation[i] != kUnknown;
    if (is_known) lower_cell[i] = height(elevation[i]);
    if (upper[i] != kUnknown) upper_cell[i] = height(upper[i] + (is_known ? elevation[i] : 0));
  }
  map.standard_deviation = ValuesOf(steps_of(2), MapSteps::kHeightM);
  map.num_points = ValuesOf(steps_of(3), 1.0f);
  layers.slope = ValuesOf(steps_of(4), MapSteps::kSlope);
  layers.roughness = ValuesOf(steps_of(5), MapSteps::kRoughnessM);
  layers.grass = ValuesOf(steps_of(6), MapSteps::kGrass);
  if (content.size() == kPlanningBytes) {
    std::memcpy(layers.kind.data, content.data() + kPlanningStepsBytes, kNumCells);
  }
}

void ReadDisplay(const std::string& content, MapRasters& tile) {
  cv::Mat1b& hazard = tile.site_map.layers.hazard;
  std::memcpy(hazard.data, content.data(), kNumCells);
  for (const uint8_t value : hazard) {
    if (value > kUnseen) Refuse("an invalid hazard");
  }
  tile.coverage = cv::Mat1b(kTileCells, kTileCells);
  std::memcpy(tile.coverage.data, content.data() + kNumCells, kNumCells);
  tile.site_map.layers.distance = ValuesOf(ReadSteps(content, 2 * kNumCells), kDistanceStepM);
}

bool IsSeen(const MapRasters& tile) {
  const auto is_known = [](float height) { return !std::isnan(height); };
  const ElevationMap& map = tile.site_map.map;
  return std::any_of(map.elevation.begin(), map.elevation.end(), is_known) ||
         std::any_of(map.upper.begin(), map.upper.end(), is_known);
}

}  // namespace

std::string SerializeTile(const MapRasters& tile) {
  const Grid& grid = tile.site_map.map.grid;
  if (grid.num_rows != kTileCells || grid.num_cols != kTileCells) {
    throw std::invalid_argument("map tile: it has not the size of a tile");
  }
  if (!IsSeen(tile)) return {};
  std::string bytes(kMagic, sizeof(kMagic));
  Append(bytes, kVersion);
  AppendPart(bytes, PlanningPart(tile.site_map));
  AppendPart(bytes, DisplayPart(tile));
  AppendPart(bytes, CuesPart(tile.cues));
  return bytes;
}

MapRasters DeserializeTile(const std::string& bytes, const Grid& grid, TileLayers layers) {
  constexpr size_t kHeadSize = sizeof(kMagic) + sizeof(kVersion);
  if (bytes.size() < kHeadSize || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    Refuse("is none");
  }
  uint32_t version = 0;
  std::memcpy(&version, bytes.data() + sizeof(kMagic), sizeof(version));
  if (version != kVersion && version != kVersionWithoutKinds) {
    throw std::runtime_error("stored map tile: version " + std::to_string(version));
  }
  MapRasters tile = UnseenRasters(grid);
  size_t position = kHeadSize;
  const auto is = [](size_t wanted) { return [wanted](size_t size) { return size == wanted; }; };
  const size_t planning_bytes = version == kVersion ? kPlanningBytes : kPlanningStepsBytes;
  ReadPlanning(ReadPart(bytes, is(planning_bytes), position), tile.site_map);
  if (layers == TileLayers::kPlanning) return tile;
  ReadDisplay(ReadPart(bytes, is(kDisplayBytes), position), tile);
  if (layers == TileLayers::kAll) return tile;
  const auto is_cues = [](size_t size) { return size <= kMaxNumCues * (kNumCells + 256); };
  tile.cues = ReadCues(ReadPart(bytes, is_cues, position));
  return tile;
}

}  // namespace freelsd
