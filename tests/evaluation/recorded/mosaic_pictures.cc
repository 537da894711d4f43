#include "tests/evaluation/recorded/mosaic_pictures.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/mosaic/mosaic.h"
#include "engine/mosaic/picture_ground.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

constexpr int kNumSeamPlaces = 20;
constexpr int kSeamPictureSidePx = 240;
constexpr int kNumSharpnessPlaces = 400;
constexpr int kSharpnessSidePx = 48;

// What all threads of this process have worked.
double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A line of /proc/self/status, megabytes.
double MemoryMb(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(field, 0) == 0) return std::stod(line.substr(field.size() + 1)) / 1024.0;
  }
  return 0.0;
}

void ForgetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

// Level 0 as one picture. Big, but recorded flights are small.
class WholePicture {
 public:
  explicit WholePicture(const MosaicLattice& lattice)
      : lattice_(lattice), image_(lattice.tiles.size() * lattice.tile_size_px, cv::Vec4b::all(0)) {}

  void Put(const MosaicTile& tile) {
    const int side = lattice_.tile_size_px;
    const cv::Point at = (cv::Point(tile.col, tile.row) - lattice_.tiles.tl()) * side;
    tile.image.copyTo(image_(cv::Rect(at, tile.image.size())));
  }
  // Fractional pixel; (0, 0) is the centre of the first.
  Eigen::Vector2d PixelOf(const Eigen::Vector2d& place_in_world) const {
    const cv::Point first = lattice_.tiles.tl() * lattice_.tile_size_px;
    return Eigen::Vector2d(place_in_world.x(), -place_in_world.y()) / lattice_.pixel_size_m -
           Eigen::Vector2d(first.x + 0.5, first.y + 0.5);
  }
  const cv::Mat4b& image() const { return image_; }

 private:
  MosaicLattice lattice_;
  cv::Mat4b image_;
};

int ViewAt(const MosaicReport& report, const Eigen::Vector2d& place) {
  const auto cell = report.seam_grid.CellAt(place);
  return cell ? report.view(*cell) : -1;
}

cv::Mat3b Crop(const cv::Mat4b& image, const cv::Point& center, int side) {
  cv::Mat3b crop(side, side, cv::Vec3b(255, 0, 255));
  const cv::Rect wanted(center.x - side / 2, center.y - side / 2, side, side);
  const cv::Rect common = wanted & cv::Rect(cv::Point(), image.size());
  for (int row = common.y; row < common.br().y; ++row) {
    for (int col = common.x; col < common.br().x; ++col) {
      const cv::Vec4b& color = image(row, col);
      if (color[3]) crop(row - wanted.y, col - wanted.x) = {color[0], color[1], color[2]};
    }
  }
  return crop;
}

// Paints the borders between views on a crop around a place.
void DrawSeams(const MosaicReport& report, const Eigen::Vector2d& center, cv::Mat3b& crop) {
  const double pixel_size_m = report.lattice.pixel_size_m;
  for (int row = 0; row + 1 < crop.rows; ++row) {
    for (int col = 0; col + 1 < crop.cols; ++col) {
      const Eigen::Vector2d place =
          center + Eigen::Vector2d(col - crop.cols / 2, crop.rows / 2 - row) * pixel_size_m;
      const int view = ViewAt(report, place);
      if (view != ViewAt(report, place + Eigen::Vector2d(pixel_size_m, 0.0)) ||
          view != ViewAt(report, place - Eigen::Vector2d(0.0, pixel_size_m))) {
        crop(row, col) = {0, 0, 255};
      }
    }
  }
}

std::vector<Eigen::Vector2d> SeamPlaces(const MosaicReport& report) {
  std::vector<Eigen::Vector2d> places;
  for (int row = 0; row + 1 < report.view.rows; ++row) {
    for (int col = 0; col + 1 < report.view.cols; ++col) {
      const int view = report.view(row, col);
      const int right = report.view(row, col + 1), below = report.view(row + 1, col);
      if (view < 0 || right < 0 || below < 0 || (view == right && view == below)) continue;
      places.push_back(report.seam_grid.CellCenter(row, col));
    }
  }
  std::mt19937 random(1);
  std::shuffle(places.begin(), places.end(), random);
  places.resize(std::min<size_t>(places.size(), kNumSeamPlaces));
  return places;
}

void WriteSeams(const WholePicture& whole, const MosaicReport& report, const fs::path& path) {
  constexpr int kNumPerRow = 4;
  const int side = kSeamPictureSidePx;
  cv::Mat3b sheet(kNumSeamPlaces / kNumPerRow * (side + 4),
                  kNumPerRow * 2 * (side + 4),
                  cv::Vec3b(255, 255, 255));
  int number = 0;
  for (const Eigen::Vector2d& place : SeamPlaces(report)) {
    const Eigen::Vector2d pixel = whole.PixelOf(place);
    const cv::Point center(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    cv::Mat3b crop = Crop(whole.image(), center, side);
    const cv::Point at(number % kNumPerRow * 2 * (side + 4), number / kNumPerRow * (side + 4));
    crop.copyTo(sheet(cv::Rect(at, crop.size())));
    DrawSeams(report, place, crop);
    crop.copyTo(sheet(cv::Rect(at + cv::Point(side + 2, 0), crop.size())));
    ++number;
  }
  cv::imwrite(path.string(), sheet);
}

double GradientEnergy(const cv::Mat& image) {
  cv::Mat1f grey, east, south;
  cv::Mat color;
  cv::cvtColor(image, color, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  color.convertTo(grey, CV_32F);
  cv::Sobel(grey, east, CV_32F, 1, 0, 1, 0.5);
  cv::Sobel(grey, south, CV_32F, 0, 1, 1, 0.5);
  return (east.dot(east) + south.dot(south)) / static_cast<double>(grey.total());
}

double HeightAt(const ElevationMap& map, const Eigen::Vector2d& place) {
  const Eigen::Vector2d at = (place - map.grid.CellCenter(0, 0)) / map.grid.cell_size_m;
  const int col = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(-at.y()));
  if (col < 0 || row < 0 || col + 1 >= map.grid.num_cols || row + 1 >= map.grid.num_rows) {
    return std::nan("");
  }
  const double u = at.x() - col, v = -at.y() - row;
  const cv::Mat1f& z = map.elevation;
  return (1 - v) * ((1 - u) * z(row, col) + u * z(row, col + 1)) +
         v * ((1 - u) * z(row + 1, col) + u * z(row + 1, col + 1));
}

// Windows within one view, in the mosaic and in its photograph.
double SharpnessRatio(const RecordedFlight& flight,
                      const ElevationMap& map,
                      const WholePicture& whole,
                      const MosaicReport& report) {
  std::mt19937 random(2);
  std::vector<double> ratios;
  const int side = kSharpnessSidePx;
  for (int i = 0; i < kNumSharpnessPlaces; ++i) {
    const int row = static_cast<int>(random() % static_cast<unsigned>(report.view.rows));
    const int col = static_cast<int>(random() % static_cast<unsigned>(report.view.cols));
    const Eigen::Vector2d place = report.seam_grid.CellCenter(row, col);
    const int view = report.view(row, col);
    const double height = HeightAt(map, place);
    if (view < 0 || std::isnan(height)) continue;
    const auto number = static_cast<size_t>(view);
    const AdjustedView& adjusted = flight.block.views[number];
    const auto pixel = flight.block.CameraOf(number).ImageFromCamera(
        Inverse(adjusted.world_from_camera) * Eigen::Vector3d(place.x(), place.y(), height));
    const Eigen::Vector2d in_whole = whole.PixelOf(place);
    if (!pixel) continue;
    const cv::Mat& image = flight.images.at(adjusted.frame_id);
    const cv::Rect source(int(pixel->x()) - side / 2, int(pixel->y()) - side / 2, side, side);
    const cv::Rect target(int(in_whole.x()) - side / 2, int(in_whole.y()) - side / 2, side, side);
    if ((source & cv::Rect(cv::Point(), image.size())) != source ||
        (target & cv::Rect(cv::Point(), whole.image().size())) != target) {
      continue;
    }
    const cv::Mat4b window = whole.image()(target);
    if (std::any_of(window.begin(), window.end(), [](const cv::Vec4b& c) { return c[3] == 0; })) {
      continue;
    }
    ratios.push_back(GradientEnergy(window) / std::max(1e-3, GradientEnergy(image(source))));
  }
  if (ratios.empty()) return 0.0;
  std::nth_element(ratios.begin(), ratios.begin() + long(ratios.size() / 2), ratios.end());
  return ratios[ratios.size() / 2];
}

// Where the mosaic shows what a view shows at a pixel: the ray meets the ground.
Eigen::Vector2d PlaceInMosaic(const PictureGround& ground,
                              const AdjustedBlock& block,
                              size_t view,
                              const Eigen::Vector2d& pixel,
                              Eigen::Vector2d place) {
  const Rigid3d& world_from_camera = block.views[view].world_from_camera;
  const Eigen::Vector3d ray = world_from_camera.rotation * block.CameraOf(view).RayFromImage(pixel);
  const Eigen::Vector3d& eye = world_from_camera.translation;
  for (int i = 0; i < 10; ++i) {
    place = (eye + ray * ((ground.HeightAt(place) - eye.z()) / ray.z())).head<2>();
  }
  return place;
}

void MeasureTargets(const RecordedFlight& flight,
                    const ElevationMap& map,
                    const std::vector<Sighting>& sightings,
                    const MosaicReport& report,
                    MosaicFigures& figures) {
  const PictureGround ground(map, {});
  double sum = 0.0;
  const auto targets = PlacesOfTargets(flight.block, sightings);
  for (const Sighting& sighting : sightings) {
    const auto target = targets.find(sighting.target);
    if (target == targets.end()) continue;
    const Eigen::Vector2d truth = target->second.head<2>();
    const int view = ViewAt(report, truth);
    if (view < 0) continue;
    const auto number = static_cast<size_t>(view);
    if (flight.block.views[number].frame_id != sighting.frame_id) continue;
    const double error_px =
        (PlaceInMosaic(ground, flight.block, number, sighting.point_in_image, truth) - truth)
            .norm() /
        report.lattice.pixel_size_m;
    if (std::isnan(error_px)) continue;
    ++figures.num_targets;
    sum += error_px * error_px;
    figures.target_largest_px = std::max(figures.target_largest_px, error_px);
  }
  if (figures.num_targets > 0) figures.target_rms_px = std::sqrt(sum / figures.num_targets);
}

}  // namespace

MosaicFigures WriteMosaic(const RecordedFlight& flight,
                          const std::string& images,
                          const ElevationMap& map,
                          const std::vector<Sighting>& sightings,
                          const std::string& output) {
  fs::create_directories(output);
  const MosaicOptions options;
  WholePicture whole(PlanMosaic(map, flight.block, options));
  double seconds_of_writing = 0.0;
  MosaicFigures figures;
  ForgetPeak();
  const double before_mb = MemoryMb("VmRSS:");
  const double start = ProcessorSeconds();
  const auto read = [&](const std::string& frame_id) {
    return cv::imread((fs::path(images) / frame_id).string(),
                      cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  };
  const MosaicReport report =
      MakeMosaic(map, flight.block, read, options, [&](const MosaicTile& tile) {
        const double start_of_writing = ProcessorSeconds();
        if (tile.level == 0) whole.Put(tile);
        const std::string name = std::to_string(tile.level) + "_" + std::to_string(tile.row) + "_" +
                                 std::to_string(tile.col) + ".png";
        cv::imwrite((fs::path(output) / name).string(), tile.image);
        seconds_of_writing += ProcessorSeconds() - start_of_writing;
      });
  figures.seconds = ProcessorSeconds() - start - seconds_of_writing;
  figures.peak_mb = std::max(0.0, MemoryMb("VmHWM:") - before_mb);
  figures.pixel_size_m = report.lattice.pixel_size_m;
  figures.num_tiles = report.num_tiles;
  figures.shown_km2 = cv::countNonZero(report.view >= 0) * report.seam_grid.cell_size_m *
                      report.seam_grid.cell_size_m * 1e-6;
  figures.step_photographed = report.step_photographed;
  figures.step_with_gains = report.step_with_gains;
  figures.step_blended = report.step_blended;
  figures.sharpness_ratio = SharpnessRatio(flight, map, whole, report);
  MeasureTargets(flight, map, sightings, report, figures);
  WriteSeams(whole, report, fs::path(output) / "seams.png");
  cv::Mat overview;
  const double factor = std::min(1.0, 1600.0 / std::max(whole.image().cols, whole.image().rows));
  cv::resize(whole.image(), overview, {}, factor, factor, cv::INTER_AREA);
  cv::imwrite((fs::path(output) / "overview.png").string(), overview);
  return figures;
}

}  // namespace freelsd
