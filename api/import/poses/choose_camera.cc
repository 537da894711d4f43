#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

// Calibrations of one lens differ less, e.g. where each photograph has its own.
constexpr double kSameCameraRatio = 0.03;

bool AreNearlyEqual(const Camera& a, const Camera& b) {
  const auto is_near = [&a](double one, double other) {
    return std::abs(one - other) <= kSameCameraRatio * std::min(a.fx_px, a.fy_px);
  };
  return a.width_px == b.width_px && a.height_px == b.height_px && a.distortion == b.distortion &&
         is_near(a.fx_px, b.fx_px) && is_near(a.fy_px, b.fy_px) && is_near(a.cx_px, b.cx_px) &&
         is_near(a.cy_px, b.cy_px);
}

// Photographs of the request, or all where the request has none, by camera.
std::map<std::string, size_t> NumbersOfImages(const SideData& data) {
  std::map<std::string, size_t> numbers;
  for (const auto& [image_id, camera_id] : data.camera_ids) {
    if (data.tags.empty() || data.tags.contains(image_id)) ++numbers[camera_id];
  }
  return numbers;
}

// Those that some photograph names; all if none is named.
std::vector<SideCamera> UsedCameras(SideData& data,
                                    const std::map<std::string, size_t>& num_images) {
  const auto is_unused = [&num_images](const SideCamera& camera) {
    return !num_images.contains(camera.id);
  };
  std::vector<SideCamera> used = data.cameras;
  std::erase_if(used, is_unused);
  if (used.empty()) return data.cameras;
  if (const size_t num = data.cameras.size() - used.size(); num > 0) {
    data.file.warnings.push_back(std::to_string(num) + " cameras of no photograph are not used");
  }
  return used;
}

// Only those without a problem, unless there is none.
std::vector<SideCamera> SoundCameras(std::vector<SideCamera> cameras, SideData& data) {
  const auto has_problem = [](const SideCamera& camera) { return camera.problem.has_value(); };
  if (std::all_of(cameras.begin(), cameras.end(), has_problem)) throw *cameras.front().problem;
  for (const SideCamera& camera : cameras) {
    if (camera.problem) data.file.warnings.emplace_back(camera.problem->what());
  }
  std::erase_if(cameras, has_problem);
  return cameras;
}

void RemovePosesOf(const std::set<std::string>& camera_ids, SideData& data) {
  size_t num = 0;
  const auto is_of_others = [&](const LocalPose& pose) {
    const auto camera = data.camera_ids.find(pose.image_id);
    return camera != data.camera_ids.end() && camera_ids.contains(camera->second);
  };
  num += std::erase_if(data.local_poses, is_of_others);
  std::erase_if(data.local_poses_w_last, is_of_others);
  data.file.warnings.push_back(
      "a flight has one camera: the poses of " + std::to_string(num) + " photographs of " +
      std::to_string(camera_ids.size()) +
      " other cameras are left out; those photographs belong into a flight of their own");
}

}  // namespace

void AddCamera(const std::string& id,
               const SideFile& file,
               const std::function<Camera()>& read,
               SideData& data) {
  SideCamera camera{id, file.path, {}, {}};
  try {
    camera.camera = read();
    camera.camera.Check();
  } catch (const ApiError& error) {
    camera.problem = error;
  } catch (const std::invalid_argument& error) {
    camera.problem = InvalidSideFile(file, 0, error.what());
  }
  data.cameras.push_back(std::move(camera));
}

void ChooseCamera(SideData& data) {
  if (data.cameras.empty()) return;
  const std::map<std::string, size_t> num_images = NumbersOfImages(data);
  const auto num_images_of = [&num_images](const SideCamera& camera) {
    const auto found = num_images.find(camera.id);
    return found == num_images.end() ? size_t{0} : found->second;
  };
  std::vector<SideCamera> cameras = SoundCameras(UsedCameras(data, num_images), data);
  // Of equally many photographs the middle focal length.
  std::stable_sort(cameras.begin(), cameras.end(), [](const auto& a, const auto& b) {
    return a.camera.fx_px < b.camera.fx_px;
  });
  std::rotate(
      cameras.begin(), cameras.begin() + static_cast<long>(cameras.size() / 2), cameras.end());
  const auto chosen =
      std::max_element(cameras.begin(), cameras.end(), [&](const auto& a, const auto& b) {
        return num_images_of(a) < num_images_of(b);
      });
  std::set<std::string> others;
  for (const SideCamera& camera : cameras) {
    if (AreNearlyEqual(camera.camera, chosen->camera)) continue;
    others.insert(camera.id);
    if (num_images_of(*chosen) > 0) continue;
    throw InvalidSideFile({data.cameras.back().path, ""},
                          0,
                          "a second camera: a flight has only one, and no file tells which "
                          "photographs are whose");
  }
  data.file.camera = chosen->camera;
  if (!others.empty()) RemovePosesOf(others, data);
  const size_t num_alike = cameras.size() - others.size();
  if (num_alike < 2 || !others.empty()) return;
  data.file.warnings.push_back(std::to_string(num_alike) +
                               " nearly equal cameras: one of them is used for all photographs");
}

}  // namespace freelsd
