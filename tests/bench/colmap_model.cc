#include "tests/bench/colmap_model.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include <Eigen/Geometry>

#include "engine/adjustment/landmarks.h"

namespace freelsd {
namespace {

constexpr size_t kMinNumViews = 3;
// Assumed pixel noise for the deviation of landmarks, as the engine assumes it.
constexpr double kPixelSd = 0.7;

std::vector<std::string> ReadLines(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() != '#') lines.push_back(line);
  }
  return lines;
}

// COLMAP's (0, 0) is the outer corner of the first pixel, ours is its centre.
Camera ReadCamera(const std::string& path) {
  const std::vector<std::string> lines = ReadLines(path);
  if (lines.size() != 1) throw std::runtime_error(path + ": expected one camera");
  std::istringstream line(lines.front());
  std::string id, kind;
  Camera camera;
  line >> id >> kind >> camera.width_px >> camera.height_px >> camera.fx_px >> camera.fy_px >>
      camera.cx_px >> camera.cy_px;
  if (!line || kind != "PINHOLE") throw std::runtime_error(path + ": expected a PINHOLE camera");
  camera.cx_px -= 0.5;
  camera.cy_px -= 0.5;
  return camera;
}

// Two lines for each image: its pose, and its points, of which there may be none.
std::map<std::string, std::string> ReadImages(const std::string& path, ColmapModel* model) {
  std::map<std::string, std::string> name_of_id;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i + 1 < lines.size(); i += 2) {
    std::istringstream line(lines[i]);
    std::string id, camera_id, name;
    Eigen::Quaterniond rotation;
    Eigen::Vector3d translation;
    line >> id >> rotation.w() >> rotation.x() >> rotation.y() >> rotation.z() >> translation.x() >>
        translation.y() >> translation.z() >> camera_id >> name;
    if (!line) throw std::runtime_error(path + ": not a pose: " + lines[i]);
    const Rigid3d camera_from_model{rotation.normalized(), translation};
    model->model_from_camera[name] = Inverse(camera_from_model);
    name_of_id[id] = name;
  }
  return name_of_id;
}

std::vector<ColmapPoint> ReadPoints(const std::string& path,
                                    const std::map<std::string, std::string>& name_of_id) {
  std::vector<ColmapPoint> points;
  for (const std::string& text : ReadLines(path)) {
    std::istringstream line(text);
    ColmapPoint point;
    std::string id, red, green, blue, error, image_id, index;
    line >> id >> point.point_in_model.x() >> point.point_in_model.y() >>
        point.point_in_model.z() >> red >> green >> blue >> error;
    if (!line) throw std::runtime_error(path + ": not a point: " + text);
    std::set<std::string> images;
    while (line >> image_id >> index) images.insert(name_of_id.at(image_id));
    point.images.assign(images.begin(), images.end());
    points.push_back(std::move(point));
  }
  return points;
}

Eigen::Affine3d WorldFromModel(const ColmapModel& model, const Positions& positions) {
  Eigen::Matrix3Xd in_model(3, 0), in_world(3, 0);
  for (const auto& [name, position] : positions) {
    const auto view = model.model_from_camera.find(name);
    if (view == model.model_from_camera.end()) continue;
    in_model.conservativeResize(3, in_model.cols() + 1);
    in_world.conservativeResize(3, in_world.cols() + 1);
    in_model.rightCols<1>() = view->second.translation;
    in_world.rightCols<1>() = position;
  }
  if (static_cast<size_t>(in_model.cols()) < kMinNumViews) {
    throw std::runtime_error("the model has fewer than three of the photographs");
  }
  return Eigen::Affine3d(Eigen::umeyama(in_model, in_world, true));
}

// Landmarks, in ascending order for each view, and how high each view is above the middle one.
void FillLandmarks(const ColmapModel& model,
                   const Eigen::Affine3d& world_from_model,
                   const std::map<std::string, size_t>& index_of_name,
                   AdjustedBlock* block) {
  BlockState state{block->camera, {}, {}};
  for (const AdjustedView& view : block->views) {
    state.world_from_camera.push_back(view.world_from_camera);
    state.readouts.push_back({});
  }
  std::vector<std::vector<double>> heights(block->views.size());
  for (const ColmapPoint& point : model.points) {
    BlockTrack track;
    track.point_in_world = world_from_model * point.point_in_model;
    track.has_point = true;
    for (const std::string& name : point.images) {
      const size_t i = index_of_name.at(name);
      track.sightings.push_back({i, Eigen::Vector2d::Zero(), true});
      block->views[i].landmarks.push_back(block->landmarks.size());
      heights[i].push_back(state.world_from_camera[i].translation.z() - track.point_in_world.z());
    }
    block->landmarks.push_back({track.point_in_world,
                                HeightDeviation(state, track, kPixelSd),
                                static_cast<int>(point.images.size())});
  }
  for (size_t i = 0; i < heights.size(); ++i) {
    if (heights[i].empty()) continue;
    const auto middle = heights[i].begin() + static_cast<std::ptrdiff_t>(heights[i].size() / 2);
    std::nth_element(heights[i].begin(), middle, heights[i].end());
    block->views[i].height_above_ground = *middle;
  }
}

}  // namespace

ColmapModel ReadColmapModel(const std::string& folder) {
  ColmapModel model;
  model.camera = ReadCamera(folder + "/cameras.txt");
  const auto name_of_id = ReadImages(folder + "/images.txt", &model);
  model.points = ReadPoints(folder + "/points3D.txt", name_of_id);
  return model;
}

AdjustedBlock BlockFrom(const ColmapModel& model, const Positions& positions) {
  const Eigen::Affine3d world_from_model = WorldFromModel(model, positions);
  const Eigen::Quaterniond rotation(Eigen::Matrix3d(world_from_model.rotation()));
  AdjustedBlock block;
  block.camera = model.camera;
  block.is_usable = true;
  std::map<std::string, size_t> index_of_name;
  for (const auto& [name, position] : positions) {
    index_of_name[name] = block.views.size();
    AdjustedView view;
    view.frame_id = name;
    view.world_from_camera.translation = position;
    if (const auto found = model.model_from_camera.find(name);
        found != model.model_from_camera.end()) {
      view.world_from_camera = {(rotation * found->second.rotation).normalized(),
                                world_from_model * found->second.translation};
      view.is_connected = true;
      view.group = 0;
    }
    block.views.push_back(std::move(view));
  }
  FillLandmarks(model, world_from_model, index_of_name, &block);
  return block;
}

}  // namespace freelsd
