// COLMAP's text model: cameras.txt and images.txt. Transforms are camera from world, quaternions w
// first, and the centre of the top-left pixel is (0.5, 0.5).
#include <algorithm>
#include <array>

#include "api/import/number_text.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kPixelCenter = 0.5;
// Of an image: id qw qx qy qz tx ty tz camera name.
constexpr size_t kNumWords = 10;

struct CameraModel {
  std::string_view name;
  size_t num_focals;
  size_t num_coefficients;
  DistortionModel distortion;
};
constexpr std::array<CameraModel, 9> kModels{{
    {"SIMPLE_PINHOLE", 1, 0, DistortionModel::kNone},
    {"PINHOLE", 2, 0, DistortionModel::kNone},
    {"SIMPLE_RADIAL", 1, 1, DistortionModel::kRadTan},
    {"RADIAL", 1, 2, DistortionModel::kRadTan},
    {"OPENCV", 2, 4, DistortionModel::kRadTan},
    {"FULL_OPENCV", 2, 8, DistortionModel::kRadTan},
    {"OPENCV_FISHEYE", 2, 4, DistortionModel::kEquidistant},
    {"SIMPLE_RADIAL_FISHEYE", 1, 1, DistortionModel::kEquidistant},
    {"RADIAL_FISHEYE", 1, 2, DistortionModel::kEquidistant},
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
  if (camera.coefficients.size() == 8) {
    // k1 k2 p1 p2 k3 and a denominator.
    const auto is_zero = [](double coefficient) { return coefficient == 0.0; };
    if (!std::all_of(camera.coefficients.begin() + 5, camera.coefficients.end(), is_zero)) {
      throw InvalidSideFile(file, line.number, "k4, k5 and k6 are not supported");
    }
    camera.coefficients.resize(5);
  } else if (model.distortion != DistortionModel::kNone) {
    // One or two radial coefficients; what follows in our order is 0.
    camera.coefficients.resize(4, 0.0);
  }
  return camera;
}

LocalPose PoseOf(const std::string& image_id,
                 const Eigen::Quaterniond& camera_from_world,
                 const Eigen::Vector3d& translation) {
  return {image_id, Inverse(Rigid3d{camera_from_world, translation})};
}

size_t EndOfWords(std::string_view line, size_t num_words) {
  size_t at = 0;
  for (size_t i = 0; i < num_words; ++i) {
    at = std::min(line.find_first_not_of(" \t", at), line.size());
    at = std::min(line.find_first_of(" \t", at), line.size());
  }
  return at;
}

}  // namespace

void ReadColmapCameras(const SideFile& file, SideData& data) {
  for (const TextLine& line : LinesOf(file.text)) {
    AddCamera(
        WordsOf(line.text).at(0), file, [&] { return ReadCamera(line, file); }, data);
  }
}

// Two lines per image: ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then its points (may be empty).
void ReadColmapImages(const SideFile& file, SideData& data) {
  bool is_pose = true;
  for (const TextLine& line : LinesOf(file.text, BlankLines::kKeep)) {
    if (line.text.rfind('#', 0) == 0) continue;
    const std::vector<std::string> words = WordsOf(line.text);
    if (is_pose && words.empty()) continue;
    // Some write no lines of points.
    is_pose = is_pose || (words.size() >= kNumWords && !NumberFromText(words.back()));
    if (is_pose) {
      if (words.size() < kNumWords) {
        throw InvalidSideFile(file, line.number, "must be: id qw qx qy qz tx ty tz camera name");
      }
      const std::vector<double> n = NumbersOf(words, 1, 8, file, line.number);
      const Eigen::Vector3d translation(n[4], n[5], n[6]);
      const int number = line.number;
      const auto quaternion = QuaternionOf(n[0], n[1], n[2], n[3], file, number);
      const auto w_last = QuaternionOf(n[3], n[0], n[1], n[2], file, number);
      // The name is the rest of the line, with its blanks.
      const size_t name = EndOfWords(line.text, kNumWords - 1);
      const std::string image_id = ImageIdOf(Trimmed(line.text.substr(name)), data.tags);
      data.camera_ids[image_id] = words[8];
      data.local_poses.push_back(PoseOf(image_id, quaternion, translation));
      data.local_poses_w_last.push_back(PoseOf(image_id, w_last, translation));
    }
    is_pose = !is_pose;
  }
}

}  // namespace freelsd
