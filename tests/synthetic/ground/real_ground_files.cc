// Reading a pack: what its rasters and outlines say.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/ground/real_ground.h"

namespace freelsd {
namespace {

// The narrower side of crowns and cars, and of all that stands on the ground: a school's roof. A
// wider disc also takes the tops off banks.
constexpr double kWidestCrownM = 12.0;
constexpr double kWidestRoofM = 24.0;
// Bare ground is sought, and smoothed, on cells of this size.
constexpr double kBareCellM = 1.0;
constexpr float kNowhere = 1e6f;
// Whatever an outline says, what stands higher than this is none of the grass.
constexpr double kTallestGrassM = 0.4;
constexpr double kTallM = 2.0;
constexpr float kUnknownHeight = -9999.0f;

std::string FolderOf(const std::string& pack) {
  const char* data = std::getenv("FREELSD_DATA");
  if (data == nullptr) {
    throw std::runtime_error("ground " + pack +
                             ": FREELSD_DATA is not set; its folder holds terrain/" + pack);
  }
  const std::filesystem::path folder = std::filesystem::path(data) / "terrain" / pack;
  if (!std::filesystem::is_directory(folder)) {
    throw std::runtime_error("ground " + pack + ": there is no " + folder.string());
  }
  return folder.string();
}

std::ifstream Open(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return file;
}

cv::Mat ReadRaster(const std::string& path, int type) {
  cv::Mat raster = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (raster.empty()) throw std::runtime_error("cannot read " + path);
  if (raster.type() != type) {
    throw std::runtime_error(path + ": pixels are " + cv::typeToString(raster.type()) + ", not " +
                             cv::typeToString(type));
  }
  return raster;
}

double MedianOf(const cv::Mat1f& values, const cv::Mat1b& is_known) {
  std::vector<float> known;
  for (int row = 0; row < values.rows; ++row) {
    for (int col = 0; col < values.cols; ++col) {
      if (is_known(row, col) != 0) known.push_back(values(row, col));
    }
  }
  if (known.empty()) throw std::runtime_error("ground: nothing of it is known");
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

// A coarse pack has no finer cells to be averaged.
double BareCellOf(const RealGround& place) { return std::max(kBareCellM, place.cell_size_m); }

// Mean of what is known within a coarse cell; `kNowhere` where nothing is. One more disc of nothing
// on every side.
cv::Mat1f Coarse(const RealGround& place, int margin) {
  const double scale = place.cell_size_m / BareCellOf(place);
  cv::Mat1f share, sum;
  const cv::Mat1f weight = cv::Mat1f(place.is_known) / 255.0f;
  cv::resize(weight, share, {}, scale, scale, cv::INTER_AREA);
  cv::resize(place.surface.mul(weight), sum, share.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::Mat1f mean = sum / share;
  mean.setTo(kNowhere, share < 0.5f);
  cv::copyMakeBorder(
      mean, mean, margin, margin, margin, margin, cv::BORDER_CONSTANT, cv::Scalar(kNowhere));
  return mean;
}

// What a disc touches that is pressed onto the surface from below: an opening.
cv::Mat1f GroundBelow(const RealGround& place, double widest_thing_m) {
  const int margin = static_cast<int>(0.5 * widest_thing_m / BareCellOf(place));
  const int side = 2 * margin + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::Mat1f low = Coarse(place, margin);
  const cv::Size size(low.cols - 2 * margin, low.rows - 2 * margin);
  cv::erode(low, low, disc);
  low.setTo(-kNowhere, low >= kNowhere);
  cv::dilate(low, low, disc);
  low.setTo(0.0f, low <= -kNowhere);
  cv::GaussianBlur(low, low, {}, 1.0);
  cv::Mat1f ground;
  cv::resize(low(cv::Rect({margin, margin}, size)), ground, place.surface.size());
  return cv::min(ground, place.surface);
}

cv::Mat1f BareGround(const RealGround& place) {
  cv::Mat1f ground = GroundBelow(place, kWidestCrownM);
  const cv::Mat1f below_roofs = GroundBelow(place, kWidestRoofM);
  below_roofs.copyTo(ground, place.surface - below_roofs > kTallM);
  return ground;
}

// What tests/synthetic/ground/PACK.txt says.
struct Outlines {
  struct Outline {
    Cover cover = Cover::kScrub;
    std::vector<cv::Point> corners;
  };
  std::vector<Outline> outlines;
  std::vector<GroundWindow> windows;
  bool has_wrong_colors = false;
};

GroundWindow ParseWindow(std::istringstream& words) {
  GroundWindow window;
  words >> window.name >> window.kind >> window.middle.x >> window.middle.y;
  if (!words || (window.kind != "field" && window.kind != "decoy")) {
    throw std::invalid_argument("a window has a name, a kind (field or decoy), column and row");
  }
  return window;
}

Outlines::Outline ParseOutline(const std::string& name, std::istringstream& words) {
  Outlines::Outline outline{CoverNamed(name), {}};
  for (cv::Point corner; words >> corner.x >> corner.y;) outline.corners.push_back(corner);
  if (outline.corners.size() < 3 || !words.eof()) throw std::invalid_argument("no outline");
  return outline;
}

Outlines ReadOutlines(const std::string& pack) {
  const std::string path = FREELSD_SOURCE_DIR "/tests/synthetic/ground/" + pack + ".txt";
  std::ifstream file = Open(path);
  Outlines read;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name;
    if (!(words >> name) || name[0] == '#') continue;
    try {
      if (name == "wrong_colors") {
        read.has_wrong_colors = true;
      } else if (name == "window") {
        read.windows.push_back(ParseWindow(words));
      } else {
        read.outlines.push_back(ParseOutline(name, words));
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(path + ": " + error.what() + ": " + line);
    }
  }
  return read;
}

// Later outlines lie over earlier ones.
void DrawOutlines(const Outlines& read, RealGround& place) {
  const cv::Mat1f height = place.surface - place.ground;
  place.cover = cv::Mat1b(height.size(), static_cast<uint8_t>(Cover::kScrub));
  place.cover.setTo(static_cast<int>(Cover::kTree), height > kTallM);
  place.variant = cv::Mat1b::zeros(height.size());
  int variant = 0;
  for (const Outlines::Outline& outline : read.outlines) {
    cv::fillPoly(place.cover, std::vector{outline.corners}, static_cast<int>(outline.cover));
    cv::fillPoly(place.variant, std::vector{outline.corners}, ++variant % 256);
  }
  const cv::Mat1b is_tall_grass =
      (place.cover == static_cast<int>(Cover::kMeadow)) & (height > kTallestGrassM);
  place.cover.setTo(static_cast<int>(Cover::kScrub), is_tall_grass);
}

// Upper left corner and cell size of a raster, in the file's own coordinates.
struct RasterGrid {
  double cell_size_m = 0.0;
  double east = 0.0;
  double north = 0.0;
};

RasterGrid GridOf(const nlohmann::json& description, const char* raster) {
  if (description.contains("gsd_m")) return {description.at("gsd_m").get<double>(), 0.0, 0.0};
  const nlohmann::json& grid = description.at(raster);
  return {grid.at("cell_size_m").get<double>(),
          grid.at("origin_easting").get<double>(),
          grid.at("origin_northing").get<double>()};
}

// Another raster on the cells of `onto`: the surface model on those of the orthophoto.
cv::Mat OnCellsOf(const RasterGrid& onto,
                  const cv::Size& size,
                  const cv::Mat& raster,
                  const RasterGrid& from,
                  int interpolation) {
  cv::Mat1f from_col(size), from_row(size);
  const double scale = onto.cell_size_m / from.cell_size_m;
  const double left = (onto.east - from.east) / from.cell_size_m - 0.5;
  const double top = (from.north - onto.north) / from.cell_size_m - 0.5;
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      from_col(row, col) = static_cast<float>(left + (col + 0.5) * scale);
      from_row(row, col) = static_cast<float>(top + (row + 0.5) * scale);
    }
  }
  cv::Mat moved;
  cv::remap(
      raster, moved, from_col, from_row, interpolation, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return moved;
}

// The orthophoto without and with the mask of where it has a picture.
void ReadPhotograph(const std::string& path, RealGround& place) {
  const cv::Mat photograph = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (photograph.empty()) throw std::runtime_error("cannot read " + path);
  if (photograph.type() == CV_8UC3) {
    place.photograph = photograph;
    // What was not photographed is black.
    cv::inRange(photograph, cv::Scalar::all(0), cv::Scalar::all(0), place.is_known);
    place.is_known = place.is_known == 0;
    return;
  }
  if (photograph.type() != CV_8UC4) {
    throw std::runtime_error(path + ": pixels are " + cv::typeToString(photograph.type()) +
                             ", not 8 bit BGR or BGRA");
  }
  cv::Mat1b alpha;
  cv::extractChannel(photograph, alpha, 3);
  cv::cvtColor(photograph, place.photograph, cv::COLOR_BGRA2BGR);
  place.is_known = alpha > 0;
}

void ReadSurface(const std::string& stem, RealGround& place) {
  const nlohmann::json description = nlohmann::json::parse(Open(stem + ".json"));
  const RasterGrid ortho = GridOf(description, "ortho"), dsm = GridOf(description, "dsm");
  place.cell_size_m = ortho.cell_size_m;
  const cv::Mat1f surface = ReadRaster(stem + "_dsm.tif", CV_32FC1);
  const cv::Mat1b is_known = surface > kUnknownHeight;
  const cv::Size size = place.photograph.size();
  if (surface.size() == size) {
    place.surface = surface;
    place.is_known &= is_known;
    return;
  }
  place.surface = OnCellsOf(ortho, size, surface, dsm, cv::INTER_LINEAR);
  // Known only where every cell that is interpolated is known.
  cv::Mat1b whole;
  cv::erode(
      is_known, whole, cv::Mat1b::ones(3, 3), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  place.is_known &= OnCellsOf(ortho, size, whole, dsm, cv::INTER_NEAREST);
}

void TakeDatum(double datum_m, RealGround& place) {
  place.datum_m += datum_m;
  place.surface -= static_cast<float>(datum_m);
  if (!place.ground.empty()) place.ground -= static_cast<float>(datum_m);
}

}  // namespace

RealGround ReadRealGround(const std::string& pack) {
  const std::string stem = FolderOf(pack) + "/" + pack;
  RealGround place;
  ReadPhotograph(stem + "_ortho.tif", place);
  ReadSurface(stem, place);
  // Without its outermost pixels, so that whoever interpolates does so between known ones.
  cv::erode(place.is_known,
            place.is_known,
            cv::Mat1b::ones(3, 3),
            {-1, -1},
            1,
            cv::BORDER_CONSTANT,
            cv::Scalar(0));
  TakeDatum(MedianOf(place.surface, place.is_known), place);
  place.ground = BareGround(place);
  const Outlines outlines = ReadOutlines(pack);
  place.has_wrong_colors = outlines.has_wrong_colors;
  DrawOutlines(outlines, place);
  return place;
}

std::vector<GroundWindow> ReadGroundWindows(const std::string& pack) {
  std::vector<GroundWindow> windows = ReadOutlines(pack).windows;
  if (windows.empty()) throw std::runtime_error("ground " + pack + ": its outlines name no window");
  return windows;
}

RealGround Cut(const RealGround& place,
               const GroundWindow& window,
               double reach_m,
               double datum_reach_m) {
  const auto area = [&](double half_side_m) {
    const int reach = static_cast<int>(std::lround(half_side_m / place.cell_size_m));
    const cv::Point middle(static_cast<int>(std::lround(window.middle.x)),
                           static_cast<int>(std::lround(window.middle.y)));
    return cv::Rect(middle - cv::Point(reach, reach), cv::Size(2 * reach + 1, 2 * reach + 1));
  };
  // Beyond the pack nothing is known.
  const cv::Rect wanted = area(reach_m), whole({0, 0}, place.surface.size());
  const cv::Rect there = wanted & whole;
  RealGround part = place;
  const auto cut = [&](cv::Mat& raster) {
    cv::Mat moved(wanted.size(), raster.type(), cv::Scalar::all(0));
    raster(there).copyTo(moved(there - wanted.tl()));
    raster = moved;
  };
  for (cv::Mat* raster : std::initializer_list<cv::Mat*>{&part.is_known,
                                                         &part.surface,
                                                         &part.ground,
                                                         &part.photograph,
                                                         &part.cover,
                                                         &part.variant}) {
    cut(*raster);
  }
  const cv::Rect middle = area(datum_reach_m) & whole;
  TakeDatum(MedianOf(place.surface(middle), place.is_known(middle)), part);
  return part;
}

}  // namespace freelsd
