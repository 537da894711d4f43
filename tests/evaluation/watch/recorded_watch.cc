#include "tests/evaluation/watch/recorded_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "tests/evaluation/fields/outlines.h"
#include "tests/evaluation/recorded/recorded_flight.h"
#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/watch/comparison_picture.h"
#include "tests/evaluation/watch/stored_ground.h"

namespace freelsd {
namespace {

constexpr double kStripLengthM = 25.0, kStripWidthM = 8.0;
// Photographs next to a part are not stored either: they show the same moment.
constexpr int kNumNeighbours = 3;
// Even ground.
constexpr double kMaxUnevennessM = 1.0;
constexpr double kMaxSlope = 0.3;
// Errors of the autopilot, as synthetic flights have them.
constexpr double kPositionSdM = 1.5, kHeightSdM = 3.0, kTiltSdDeg = 1.0, kYawSdDeg = 2.0;

Polygon StripAt(const Eigen::Vector2d& middle, double heading) {
  const Eigen::Vector2d along = 0.5 * kStripLengthM * DirectionOf(heading);
  const Eigen::Vector2d across =
      0.5 * kStripWidthM * Eigen::Vector2d(DirectionOf(heading).y(), -DirectionOf(heading).x());
  return {middle - along - across,
          middle - along + across,
          middle + along + across,
          middle + along - across};
}

// Whether nearly all of it is seen, and near one plane that is not steep.
bool IsEven(const ElevationMap& map, const Polygon& outline) {
  constexpr double kLeastRatio = 0.95;
  std::vector<Eigen::Vector4d> rows;
  for (const cv::Point& cell : map.grid.CellsIn(outline)) {
    const double elevation = map.elevation(cell);
    if (std::isnan(elevation) || map.upper(cell) - elevation > kMaxUnevennessM) continue;
    rows.emplace_back(cell.x, cell.y, 1.0, elevation);
  }
  const auto count = static_cast<double>(rows.size());
  if (count < kLeastRatio * kStripLengthM * kStripWidthM) return false;
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>> all(
      rows.front().data(), static_cast<int>(rows.size()), 4);
  const Eigen::Vector3d plane = all.leftCols<3>().colPivHouseholderQr().solve(all.col(3));
  const Eigen::ArrayXd rest = (all.leftCols<3>() * plane - all.col(3)).cwiseAbs();
  const auto num_even = static_cast<double>((rest < kMaxUnevennessM).count());
  return plane.head<2>().norm() < kMaxSlope && num_even > kLeastRatio * count;
}

// Ground and things that people outlined on one photograph.
struct OutlinedPhoto {
  Camera camera;
  Rigid3d camera_from_world;
  std::vector<Polygon> land, danger;
};

std::vector<OutlinedPhoto> OutlinedPhotos(const RecordedFlight& flight, const std::string& name) {
  const std::string file =
      std::string(FREELSD_SOURCE_DIR) + "/tests/evaluation/fields/outlines/" + name + ".txt";
  const std::vector<Outline> outlines = ParseOutlines(ReadTextFile(file), file);
  std::vector<OutlinedPhoto> photos;
  for (size_t i = 0; i < flight.block.views.size(); ++i) {
    const AdjustedView& view = flight.block.views[i];
    OutlinedPhoto photo{flight.block.CameraOf(i), Inverse(view.world_from_camera), {}, {}};
    for (const Outline& outline : outlines) {
      if (std::filesystem::path(view.frame_id).stem() != outline.photograph) continue;
      (outline.kind == OutlineKind::kLand ? photo.land : photo.danger)
          .push_back(outline.corners_in_image);
    }
    if (view.is_connected && !photo.land.empty()) photos.push_back(std::move(photo));
  }
  return photos;
}

// Whether a photograph shows that the whole strip is land, and that nothing stands on it.
bool IsLand(const OutlinedPhoto& photo, const Polygon& strip, double height) {
  Polygon in_image;
  for (const Eigen::Vector2d& corner : strip) {
    const auto pixel = photo.camera.ImageFromCamera(
        photo.camera_from_world * Eigen::Vector3d(corner.x(), corner.y(), height));
    if (!pixel) return false;
    in_image.push_back(*pixel);
  }
  const bool is_inside = std::any_of(photo.land.begin(), photo.land.end(), [&](const auto& land) {
    return std::all_of(in_image.begin(), in_image.end(), [&](const auto& corner) {
      return Contains(land, corner);
    });
  });
  return is_inside &&
         std::none_of(photo.danger.begin(), photo.danger.end(), [&](const Polygon& danger) {
           return std::any_of(danger.begin(), danger.end(), [&](const auto& corner) {
             return Contains(in_image, corner);
           });
         });
}

std::vector<Polygon> LandStrips(const ElevationMap& map,
                                const std::vector<OutlinedPhoto>& photos,
                                double spacing_m) {
  std::vector<Polygon> strips;
  const int step = std::max(1, static_cast<int>(spacing_m / map.grid.cell_size_m));
  for (int row = 0; row < map.grid.num_rows; row += step) {
    for (int col = 0; col < map.grid.num_cols; col += step) {
      for (const double heading : {0.0, 0.5 * kPi}) {
        const Polygon outline = StripAt(map.grid.CellCenter(row, col), heading);
        if (!IsEven(map, outline)) continue;
        const double height = map.elevation(row, col);
        const bool is_land = std::any_of(photos.begin(), photos.end(), [&](const auto& photo) {
          return IsLand(photo, outline, height);
        });
        if (!is_land || std::isnan(height)) continue;
        strips.push_back(outline);
        break;
      }
    }
  }
  return strips;
}

Rigid3d Inexact(const Rigid3d& pose, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sd) { return sd * normal(random); };
  Rigid3d inexact = pose;
  inexact.translation += Eigen::Vector3d(draw(kPositionSdM), draw(kPositionSdM), draw(kHeightSdM));
  const Eigen::Vector3d turn(
      RadFromDeg(draw(kTiltSdDeg)), RadFromDeg(draw(kTiltSdDeg)), RadFromDeg(draw(kYawSdDeg)));
  inexact.rotation = pose.rotation * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return inexact;
}

// Most corners of the strip lie in the photograph.
bool ShowsMost(const Camera& camera, const Rigid3d& pose, const Polygon& strip, double height) {
  const Rigid3d camera_from_world = Inverse(pose);
  const auto num_shown = std::count_if(strip.begin(), strip.end(), [&](const auto& corner) {
    const auto pixel =
        camera.ImageFromCamera(camera_from_world * Eigen::Vector3d(corner.x(), corner.y(), height));
    return pixel && camera.IsInside(*pixel);
  });
  return num_shown >= 3;
}

struct Part {
  const RecordedFlight& flight;
  const StoredGround& stored;
  std::string name;
  size_t first = 0, last = 0;
};

std::vector<WatchRow> WatchStrip(const Part& part,
                                 const Polygon& outline,
                                 double height,
                                 const std::string& name,
                                 const RecordedWatchOptions& options) {
  std::vector<WatchRow> rows;
  StripWatch watch(options.watch);
  const StripPicture strip = part.stored.Around({outline}, options.watch);
  for (size_t i = part.first; i < part.last; ++i) {
    const AdjustedView& view = part.flight.block.views[i];
    const Camera camera = part.flight.block.CameraOf(i);
    if (!view.is_connected || !ShowsMost(camera, view.world_from_camera, outline, height)) continue;
    const WatchedPhoto photo{part.flight.images.at(view.frame_id),
                             camera,
                             Inexact(view.world_from_camera, i),
                             part.flight.views[i].timestamp_us};
    const StripLook look = LookAtStrip(strip, photo, options.watch);
    const StripWatch::Report report = watch.Add(look);
    WatchRow row;
    row.pass = name;
    row.event = NameOf(WatchEvent::kNone);
    row.change = part.name;
    row.height_m = view.height_above_ground;
    row.number = static_cast<int>(i);
    row.result = look.result;
    row.status = report.status;
    row.compared_ratio = look.compared_ratio;
    row.correlation = look.correlation;
    row.num_things = static_cast<int>(look.things.size());
    row.deviations = look.things.empty() ? 0.0 : look.things.front().deviations;
    if (!options.pictures.empty() && row.num_things > 0) {
      WriteComparison(strip,
                      photo,
                      options.watch,
                      options.pictures + "/" + name + "_" + std::to_string(i) + ".png");
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::vector<WatchRow> WatchRecorded(const std::string& folder,
                                    const RecordedWatchOptions& options,
                                    const Classifier& classifier) {
  const PipelineOptions pipeline;
  const RecordedFlight flight = AdjustRecordedFlight(folder, classifier, pipeline);
  const ElevationMap map = MapOfBlock(flight, pipeline);
  const std::string name = std::filesystem::path(folder).filename().string();
  const std::vector<Polygon> strips =
      LandStrips(map, OutlinedPhotos(flight, name), options.spacing_m);
  std::fprintf(stderr, "%s: %zu strips\n", name.c_str(), strips.size());
  const auto num_views = static_cast<int>(flight.block.views.size());
  std::vector<WatchRow> rows;
  for (int part = 0; part < options.num_parts; ++part) {
    const int first = part * num_views / options.num_parts;
    const int last = (part + 1) * num_views / options.num_parts;
    std::set<std::string> left_out;
    for (int i = std::max(0, first - kNumNeighbours);
         i < std::min(num_views, last + kNumNeighbours);
         ++i) {
      left_out.insert(flight.block.views[static_cast<size_t>(i)].frame_id);
    }
    const StoredGround stored(map, flight.block, [&](const std::string& id) {
      return left_out.contains(id) ? cv::Mat() : flight.images.at(id);
    });
    const Part each{flight, stored, name, static_cast<size_t>(first), static_cast<size_t>(last)};
    for (size_t i = 0; i < strips.size(); ++i) {
      const auto cell = map.grid.CellAt(Centroid(strips[i]));
      const std::string label = name + "-" + std::to_string(part) + "-" + std::to_string(i);
      const auto more = WatchStrip(each, strips[i], map.elevation(*cell), label, options);
      rows.insert(rows.end(), more.begin(), more.end());
    }
  }
  return rows;
}

}  // namespace freelsd
