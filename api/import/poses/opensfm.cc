// OpenSfM's reconstruction.json (also ODM's), with reference_lla.json. Shots are camera from world,
// rotations axis times angle; lengths of the camera are in units of the image's longer side.
#include <algorithm>
#include <cmath>

#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

double NumberAt(const nlohmann::json& object,
                const std::string& key,
                std::optional<double> fallback,
                const SideFile& file) {
  const auto found = object.find(key);
  if (found == object.end() && fallback) return *fallback;
  if (found == object.end() || !found->is_number()) {
    throw InvalidSideFile(file, 0, key + ": must be a number");
  }
  return *found;
}

const nlohmann::json& ObjectAt(const nlohmann::json& object,
                               const std::string& key,
                               const SideFile& file) {
  const auto found = object.find(key);
  if (found != object.end() && found->is_object()) return *found;
  throw InvalidSideFile(file, 0, key + ": is needed");
}

Eigen::Vector3d VectorAt(const nlohmann::json& object,
                         const std::string& key,
                         const SideFile& file) {
  const auto found = object.find(key);
  const bool is_vector =
      found != object.end() && found->is_array() && found->size() == 3 &&
      std::all_of(found->begin(), found->end(), [](const auto& x) { return x.is_number(); });
  if (!is_vector) throw InvalidSideFile(file, 0, key + ": must be three numbers");
  return {(*found)[0].get<double>(), (*found)[1].get<double>(), (*found)[2].get<double>()};
}

// The principal point counts from the image's centre, ((width - 1) / 2, (height - 1) / 2).
Camera CameraOf(const nlohmann::json& object, const SideFile& file) {
  const auto number = [&](const std::string& key, std::optional<double> fallback = std::nullopt) {
    return NumberAt(object, key, fallback, file);
  };
  Camera camera;
  const double width = number("width"), height = number("height");
  const double unit_px = std::max(width, height);
  camera.width_px = width >= 1 && width <= 1e5 ? static_cast<int>(width) : 0;
  camera.height_px = height >= 1 && height <= 1e5 ? static_cast<int>(height) : 0;
  const bool has_one_focal = object.contains("focal");
  camera.fx_px = unit_px * number(has_one_focal ? "focal" : "focal_x");
  camera.fy_px = unit_px * number(has_one_focal ? "focal" : "focal_y");
  camera.cx_px = 0.5 * (width - 1.0) + unit_px * number("c_x", 0.0);
  camera.cy_px = 0.5 * (height - 1.0) + unit_px * number("c_y", 0.0);
  const std::string type = object.value("projection_type", "");
  if (type == "fisheye" || type == "fisheye_opencv") {
    camera.distortion = DistortionModel::kEquidistant;
    camera.coefficients = {
        number("k1", 0.0), number("k2", 0.0), number("k3", 0.0), number("k4", 0.0)};
  } else if (type == "perspective" || type == "brown" || type == "simple_radial" ||
             type == "radial") {
    camera.distortion = DistortionModel::kRadTan;
    camera.coefficients = {number("k1", 0.0),
                           number("k2", 0.0),
                           number("p1", 0.0),
                           number("p2", 0.0),
                           number("k3", 0.0)};
  } else {
    throw InvalidSideFile(file, 0, "projection_type " + ShownPath(type) + " is not supported");
  }
  return camera;
}

void SetReference(const nlohmann::json& object, const SideFile& file, SideData& data) {
  const GeoPoint origin{NumberAt(object, "latitude", std::nullopt, file),
                        NumberAt(object, "longitude", std::nullopt, file),
                        NumberAt(object, "altitude", std::nullopt, file)};
  if (std::abs(origin.latitude_deg) > 90.0 || std::abs(origin.longitude_deg) > 180.0) {
    throw InvalidSideFile(file, 0, "the reference is not on the earth");
  }
  data.local_origin = origin;
}

LocalPose PoseOf(const std::string& image_id, const nlohmann::json& shot, const SideFile& file) {
  const Eigen::Vector3d axis_angle = VectorAt(shot, "rotation", file);
  Rigid3d camera_from_world;
  if (axis_angle.norm() > 0.0) {
    camera_from_world.rotation = Eigen::AngleAxisd(axis_angle.norm(), axis_angle.normalized());
  }
  camera_from_world.translation = VectorAt(shot, "translation", file);
  return {image_id, Inverse(camera_from_world)};
}

nlohmann::json JsonOf(const SideFile& file) {
  try {
    return ParseJson(file.text, file.text.size() + 1);
  } catch (const ApiError& error) {
    throw InvalidSideFile(file, 0, error.what());
  }
}

void ReadCameras(const nlohmann::json& cameras, const SideFile& file, SideData& data) {
  for (const auto& [id, camera] : cameras.items()) {
    const nlohmann::json& each = camera;
    if (!each.is_object()) throw InvalidSideFile(file, 0, "must be an object of cameras");
    AddCamera(
        id, file, [&] { return CameraOf(each, file); }, data);
  }
}

}  // namespace

void ReadOpenSfm(const SideFile& file, SideData& data) {
  const nlohmann::json reconstructions = JsonOf(file);
  const auto is_object = [](const nlohmann::json& each) { return each.is_object(); };
  if (!reconstructions.is_array() || reconstructions.empty() ||
      !std::all_of(reconstructions.begin(), reconstructions.end(), is_object)) {
    throw InvalidSideFile(file, 0, "must be a list of reconstructions");
  }
  const auto largest = std::max_element(
      reconstructions.begin(), reconstructions.end(), [](const auto& a, const auto& b) {
        return a.value("shots", nlohmann::json()).size() <
               b.value("shots", nlohmann::json()).size();
      });
  if (reconstructions.size() > 1) {
    data.file.warnings.push_back("opensfm: only the largest of " +
                                 std::to_string(reconstructions.size()) +
                                 " reconstructions is used");
  }
  ReadCameras(ObjectAt(*largest, "cameras", file), file, data);
  for (const auto& [image, shot] : ObjectAt(*largest, "shots", file).items()) {
    const std::string image_id = ImageIdOf(image, data.tags);
    data.local_poses.push_back(PoseOf(image_id, shot, file));
    const auto camera = shot.find("camera");
    if (camera != shot.end() && camera->is_string()) data.camera_ids[image_id] = *camera;
  }
  if (largest->contains("reference_lla")) SetReference((*largest)["reference_lla"], file, data);
}

void ReadOpenSfmCameras(const SideFile& file, SideData& data) {
  ReadCameras(JsonOf(file), file, data);
}

void ReadReferenceLla(const SideFile& file, SideData& data) {
  SetReference(JsonOf(file), file, data);
}

}  // namespace freelsd
