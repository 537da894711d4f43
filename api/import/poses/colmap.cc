// COLMAP's text model: cameras.txt and images.txt. Transforms are camera from world, quaternions w
// first, and the centre of the top-left pixel is (0.5, 0.5).
#include <array>

#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kPixelCenter = 0.5;

struct CameraModel {
  std::string_view name;
  size_t num_focals;
  size_t num_coefficients;
  DistortionModel distortion;
};
constexpr std::array<CameraModel, 6> kModels{{
    {"SIMPLE_PINHOLE", 1, 0, DistortionModel::kNone},
    {"PINHOLE", 2, 0, DistortionModel::kNone},
    {"SIMPLE_RADIAL", 1, 1, DistortionModel::kRadTan},
    {"RADIAL", 1, 2, DistortionModel::kRadTan},
    {"OPENCV", 2, 4, DistortionModel::kRadTan},
    {"OPENCV_FISHEYE", 2, 4, DistortionModel::kEquidistant},
}};

const CameraModel& ModelOf(const std::string& name, const SideFile& file, int line) {
  for (const CameraModel& model : kModels) {
    if (model.name == name) return model;
  }
  throw InvalidSideFile(file, line, "the camera model " + ShownPath(name) + " is not supported");
}

// ID MODEL WIDTH HEIGHT focals cx cy coefficients
Camera ReadCamera(const TextLine& line, const SideFile& file) {
  const std::vector<std::string> words = WordsOf(line.text);
  if (words.size() < 4) throw InvalidSideFile(file, line.number, "must be: id model width height");
  const CameraModel& model = ModelOf(words[1], file, line.number);
  const size_t num_parameters = model.num_focals + 2 + model.num_coefficients;
  if (words.size() != 4 + num_parameters) {
    throw InvalidSideFile(
        file, line.number, "must have " + std::to_string(num_parameters) + " parameters");
  }
  const std::vector<double> size = NumbersOf(words, 2, 4, file, line.number);
  const std::vector<double> numbers = NumbersOf(words, 4, words.size(), file, line.number);
  Camera camera;
  camera.width_px = size[0] >= 1 && size[0] <= 1e5 ? static_cast<int>(size[0]) : 0;
  camera.height_px = size[1] >= 1 && size[1] <= 1e5 ? static_cast<int>(size[1]) : 0;
  camera.fx_px = numbers[0];
  camera.fy_px = numbers[model.num_focals - 1];
  camera.cx_px = numbers[model.num_focals] - kPixelCenter;
  camera.cy_px = numbers[model.num_focals + 1] - kPixelCenter;
  camera.distortion = model.distortion;
  camera.coefficients.assign(numbers.begin() + static_cast<long>(model.num_focals + 2),
                             numbers.end());
  // One or two radial coefficients; p1 and p2 follow in our order.
  if (model.distortion == DistortionModel::kRadTan) camera.coefficients.resize(4, 0.0);
  return camera;
}

LocalPose PoseOf(const std::string& image,
                 const Eigen::Quaterniond& camera_from_world,
                 const Eigen::Vector3d& translation) {
  return {IdFromFileName(image), Inverse(Rigid3d{camera_from_world, translation})};
}

}  // namespace

void ReadColmapCameras(const SideFile& file, SideData& data) {
  for (const TextLine& line : LinesOf(file.text)) SetCamera(ReadCamera(line, file), file, data);
}

// Two lines per image: ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then its points (may be empty).
void ReadColmapImages(const SideFile& file, SideData& data) {
  bool is_pose = true;
  for (const TextLine& line : LinesOf(file.text, BlankLines::kKeep)) {
    if (line.text.rfind('#', 0) == 0) continue;
    const std::vector<std::string> words = WordsOf(line.text);
    if (is_pose && words.empty()) continue;
    if (is_pose) {
      if (words.size() < 10) {
        throw InvalidSideFile(file, line.number, "must be: id qw qx qy qz tx ty tz camera name");
      }
      const std::vector<double> n = NumbersOf(words, 1, 8, file, line.number);
      const Eigen::Vector3d translation(n[4], n[5], n[6]);
      const int number = line.number;
      const auto quaternion = QuaternionOf(n[0], n[1], n[2], n[3], file, number);
      const auto w_last = QuaternionOf(n[3], n[0], n[1], n[2], file, number);
      data.local_poses.push_back(PoseOf(words[9], quaternion, translation));
      data.local_poses_w_last.push_back(PoseOf(words[9], w_last, translation));
    }
    is_pose = !is_pose;
  }
}

}  // namespace freelsd
