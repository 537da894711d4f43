// Cameras as Kalibr and ROS write them. In both, pixel (0, 0) is the centre of the top-left one, as
// ours.
#include "api/import/poses/side_files.h"
#include "api/import/poses/yaml.h"

namespace freelsd {
namespace {

nlohmann::json YamlOf(const SideFile& file) {
  try {
    return ParseYaml(file.text);
  } catch (const std::invalid_argument& error) {
    throw InvalidSideFile(file, 0, error.what());
  }
}

const nlohmann::json& At(const nlohmann::json& map, const std::string& key, const SideFile& file) {
  if (map.is_object() && map.contains(key)) return map.at(key);
  throw InvalidSideFile(file, 0, key + ": is needed");
}

// Reads numbers in one list or in rows.
void AppendNumbers(const nlohmann::json& value,
                   const std::string& key,
                   const SideFile& file,
                   std::vector<double>& numbers) {
  if (value.is_number()) {
    numbers.push_back(value);
  } else if (value.is_array()) {
    for (const nlohmann::json& item : value) AppendNumbers(item, key, file, numbers);
  } else {
    throw InvalidSideFile(file, 0, key + ": must be numbers");
  }
}

std::vector<double> NumbersAt(const nlohmann::json& map,
                              const std::string& key,
                              std::optional<size_t> size,
                              const SideFile& file) {
  const nlohmann::json* value = &At(map, key, file);
  // ROS and OpenCV: {rows, cols, data}.
  if (value->is_object()) value = &At(*value, "data", file);
  std::vector<double> numbers;
  AppendNumbers(*value, key, file, numbers);
  if (size && numbers.size() != *size) {
    throw InvalidSideFile(file, 0, key + ": must be " + std::to_string(*size) + " numbers");
  }
  return numbers;
}

std::string TextAt(const nlohmann::json& map, const std::string& key, const SideFile& file) {
  const nlohmann::json& value = At(map, key, file);
  if (!value.is_string()) throw InvalidSideFile(file, 0, key + ": must be text");
  return value;
}

Camera CameraOf(const std::vector<double>& focal_and_center, double width, double height) {
  Camera camera;
  const auto side = [](double number) {
    return number >= 1.0 && number <= 1e5 ? static_cast<int>(number) : 0;
  };
  camera.width_px = side(width);
  camera.height_px = side(height);
  camera.fx_px = focal_and_center[0];
  camera.fy_px = focal_and_center[1];
  camera.cx_px = focal_and_center[2];
  camera.cy_px = focal_and_center[3];
  return camera;
}

// Returns `size` coefficients. Further coefficients in the file must be zero.
std::vector<double> FirstOf(std::vector<double> coefficients, size_t size, const SideFile& file) {
  for (size_t i = size; i < coefficients.size(); ++i) {
    if (coefficients[i] != 0.0) {
      throw InvalidSideFile(file, 0, "this distortion has more coefficients than are supported");
    }
  }
  if (coefficients.size() > size) coefficients.resize(size);
  return coefficients;
}

void SetDistortion(const std::string& model,
                   const std::vector<double>& coefficients,
                   const SideFile& file,
                   Camera& camera) {
  if (model == "none" || model.empty()) return;
  if (model == "radtan" || model == "radial-tangential" || model == "plumb_bob" ||
      model == "rational_polynomial") {
    // All four begin with k1, k2, p1, p2[, k3].
    camera.distortion = DistortionModel::kRadTan;
    camera.coefficients = FirstOf(coefficients, 5, file);
  } else if (model == "equidistant" || model == "fisheye") {
    camera.distortion = DistortionModel::kEquidistant;
    camera.coefficients = FirstOf(coefficients, 4, file);
  } else {
    throw InvalidSideFile(file, 0, "the distortion \"" + ShownPath(model) + "\" is not supported");
  }
}

void RefuseUnlessPinhole(const nlohmann::json& map, const SideFile& file) {
  if (TextAt(map, "camera_model", file) == "pinhole") return;
  throw InvalidSideFile(file, 0, "camera_model: only pinhole is supported");
}

Camera PinholeOf(const nlohmann::json& map, const SideFile& file) {
  RefuseUnlessPinhole(map, file);
  const std::vector<double> size = NumbersAt(map, "resolution", 2, file);
  return CameraOf(NumbersAt(map, "intrinsics", 4, file), size[0], size[1]);
}

}  // namespace

void ReadKalibr(const SideFile& file, SideData& data) {
  const nlohmann::json yaml = YamlOf(file);
  const nlohmann::json& entry = At(yaml, "cam0", file);
  Camera camera = PinholeOf(entry, file);
  const std::string model = TextAt(entry, "distortion_model", file);
  if (model != "none") {
    SetDistortion(model, NumbersAt(entry, "distortion_coeffs", 4, file), file, camera);
  }
  AddCamera(
      "", file, [&camera] { return camera; }, data);
  if (yaml.contains("cam1")) {
    data.file.warnings.push_back(ShownPath(file.path) + ": only cam0 of the chain is used");
  }
}

void ReadCameraInfo(const SideFile& file, SideData& data) {
  const nlohmann::json yaml = YamlOf(file);
  const std::vector<double> matrix = NumbersAt(yaml, "camera_matrix", 9, file);
  const std::vector<double> width = NumbersAt(yaml, "image_width", 1, file);
  const std::vector<double> height = NumbersAt(yaml, "image_height", 1, file);
  Camera camera = CameraOf({matrix[0], matrix[4], matrix[2], matrix[5]}, width[0], height[0]);
  SetDistortion(TextAt(yaml, "distortion_model", file),
                NumbersAt(yaml, "distortion_coefficients", std::nullopt, file),
                file,
                camera);
  AddCamera(
      "", file, [&camera] { return camera; }, data);
}

}  // namespace freelsd
