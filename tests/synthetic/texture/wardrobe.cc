#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"
#include "tests/synthetic/texture/texture.h"

namespace freelsd {
namespace {

constexpr const char* kSources = FREELSD_SOURCE_DIR "/tests/synthetic/texture/sources.csv";
constexpr uint64_t kTexturePurpose = 711;
// Of RecordedTexture.
constexpr double kEdgeRatio = 0.17;
constexpr double kEdgeRatioOfRows = 0.34;
// Of a crown's leaves in space the renderer knows more than a picture from above.
bool HasLeaves(Cover cover) {
  return cover == Cover::kTree || cover == Cover::kBareTree || cover == Cover::kHedge;
}

TextureSource ParseSource(const std::string& line) {
  std::istringstream cells(line);
  const auto next = [&] {
    std::string cell;
    std::getline(cells, cell, ',');
    return cell;
  };
  TextureSource source;
  source.pool = next();
  source.cover = CoverNamed(next());
  source.kind = next();
  source.photograph = next();
  source.ground_sampling_m = std::stod(next());
  for (int* value : {&source.area.x, &source.area.y, &source.area.width, &source.area.height}) {
    *value = std::stoi(next());
  }
  source.split = next();
  if (source.split != "place" && source.split != "photograph") {
    throw std::invalid_argument("split must be place or photograph");
  }
  return source;
}

cv::Mat3b ReadPiece(const TextureSource& source, double cell_size_m) {
  const char* data = std::getenv("FREELSD_DATA");
  if (data == nullptr) throw std::runtime_error("recorded texture: FREELSD_DATA is not set");
  const std::string path = std::string(data) + "/" + source.photograph;
  const cv::Mat3b photograph = cv::imread(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (photograph.empty()) throw std::runtime_error("recorded texture: cannot read " + path);
  if ((cv::Rect({0, 0}, photograph.size()) & source.area) != source.area) {
    throw std::runtime_error("recorded texture: the area is not within " + path);
  }
  const double scale = source.ground_sampling_m / cell_size_m;
  cv::Mat3b piece;
  cv::resize(photograph(source.area),
             piece,
             {},
             scale,
             scale,
             scale < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return piece;
}

float Brightness(const cv::Vec3f& color) { return (color[0] + color[1] + color[2]) / 3.0f; }

// Mean brightness of what was painted, by cover and variant.
class PaintedBrightness {
 public:
  explicit PaintedBrightness(const World& world) {
    for (int row = 0; row < world.num_cells(); ++row) {
      for (int col = 0; col < world.num_cells(); ++col) {
        Entry& entry = entries_[Index(world.cover(row, col), world.variant(row, col))];
        entry.sum += Brightness(world.albedo(row, col));
        ++entry.count;
      }
    }
  }
  float Of(uint8_t cover, uint8_t variant) const {
    const Entry& entry = entries_[Index(cover, variant)];
    return static_cast<float>(entry.sum / static_cast<double>(entry.count));
  }

 private:
  struct Entry {
    double sum = 0.0;
    int64_t count = 0;
  };
  static size_t Index(uint8_t cover, uint8_t variant) { return size_t{cover} * 256 + variant; }
  std::vector<Entry> entries_ = std::vector<Entry>(size_t{kNumCovers} * 256);
};

// One of eight: a field's rows and stripes have its own direction, and no cell is interpolated.
cv::Vec3f Turned(const RecordedTexture& texture, uint8_t variant, int col, int row) {
  if ((variant & 1) != 0) std::swap(col, row);
  return texture.At((variant & 2) != 0 ? -col : col, (variant & 4) != 0 ? -row : row);
}

cv::Vec3b Rounded(const cv::Vec3f& color) {
  cv::Vec3b rounded;
  for (int i = 0; i < 3; ++i) rounded[i] = cv::saturate_cast<uint8_t>(color[i]);
  return rounded;
}

}  // namespace

std::vector<TextureSource> ReadTextureSources() {
  std::ifstream file(kSources);
  if (!file) throw std::runtime_error(std::string("cannot read ") + kSources);
  std::vector<TextureSource> sources;
  std::string line;
  std::getline(file, line);  // names of the columns
  while (std::getline(file, line)) {
    if (line.empty() || line.front() == '#') continue;
    try {
      sources.push_back(ParseSource(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(std::string(kSources) + ": cannot understand the line '" + line +
                               "': " + error.what());
    }
  }
  return sources;
}

Wardrobe Wardrobe::Read(const std::string& pool, double cell_size_m) {
  Wardrobe wardrobe;
  for (const TextureSource& source : ReadTextureSources()) {
    if (source.pool != pool) continue;
    auto& textures = wardrobe.textures_[static_cast<size_t>(source.cover)];
    const double edge_ratio = source.kind == "straw rows" ? kEdgeRatioOfRows : kEdgeRatio;
    textures.emplace_back(
        ReadPiece(source, cell_size_m), MixSeed(kTexturePurpose, textures.size()), edge_ratio);
  }
  return wardrobe;
}

const RecordedTexture* Wardrobe::For(Cover cover, uint8_t variant) const {
  const std::vector<RecordedTexture>& textures = textures_[static_cast<size_t>(cover)];
  if (textures.empty()) return nullptr;
  return &textures[MixSeed(kTexturePurpose, variant) % textures.size()];
}

void Clothe(World& world, const Wardrobe& wardrobe) {
  const PaintedBrightness painted(world);
  world.is_textured = cv::Mat1b::zeros(world.cover.size());
  ForEachCell(world, [&](int row, int col) {
    const uint8_t variant = world.variant(row, col);
    const auto cover = static_cast<Cover>(world.cover(row, col));
    const RecordedTexture* texture = wardrobe.For(cover, variant);
    if (texture == nullptr || HasLeaves(cover)) return;
    const bool is_photographed = !world.photographed.empty() && world.photographed(row, col) != 0;
    if (is_photographed && !world.is_photograph_coarse) return;
    const cv::Vec3f color = Turned(*texture, variant, col, row);
    cv::Vec3b& albedo = world.albedo(row, col);
    if (is_photographed) {
      // The place's own hue: only the detail is the texture's.
      albedo = Rounded(cv::Vec3f(albedo) * (Brightness(color) / Brightness(texture->mean())));
    } else {
      const float gain = painted.Of(world.cover(row, col), variant) / Brightness(texture->mean());
      albedo = Rounded(gain * color);
    }
    world.is_textured(row, col) = 255;
  });
  world.Light();
}

}  // namespace freelsd
