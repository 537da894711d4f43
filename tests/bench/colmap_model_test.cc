#include "tests/bench/colmap_model.h"

#include <filesystem>
#include <fstream>
#include <iomanip>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kMaxErrorM = 1e-6;

// A folder of its own, removed at the end.
struct ModelFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "freelsd_colmap_model_test";

  ModelFolder() { std::filesystem::create_directories(path); }
  ~ModelFolder() { std::filesystem::remove_all(path); }

  std::ofstream File(const char* name) const {
    std::ofstream file(path / name);
    file << "# a comment\n" << std::setprecision(17);
    return file;
  }
};

const Rigid3d kModelFromWorld{
    Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized())),
    {3.0, -2.0, 5.0}};
constexpr double kModelMetresPerWorldMetre = 0.04;

Eigen::Vector3d InModel(const Eigen::Vector3d& point_in_world) {
  return kModelMetresPerWorldMetre * (kModelFromWorld * point_in_world);
}

Positions CamerasInWorld() {
  return {{"a.jpg", {0.0, 0.0, 100.0}},
          {"b.jpg", {13.0, 1.0, 99.0}},
          {"c.jpg", {26.0, -1.0, 101.0}},
          {"d.jpg", {26.0, 50.0, 100.0}},
          {"not placed.jpg", {40.0, 0.0, 100.0}}};
}

const Eigen::Quaterniond kWorldFromCamera(Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX()));

// Of those cameras but the last, and of two points.
void WriteModel(const ModelFolder& folder) {
  folder.File("cameras.txt") << "1 PINHOLE 752 480 465 466 376 240\n";
  std::ofstream images = folder.File("images.txt");
  int id = 0;
  for (const auto& [name, position] : CamerasInWorld()) {
    if (name == "not placed.jpg") continue;
    const Eigen::Quaterniond rotation = (kModelFromWorld.rotation * kWorldFromCamera).conjugate();
    const Eigen::Vector3d translation = -(rotation * InModel(position));
    images << ++id << " " << rotation.w() << " " << rotation.x() << " " << rotation.y() << " "
           << rotation.z() << " " << translation.transpose() << " 1 " << name << "\n\n";
  }
  folder.File("points3D.txt") << "7 " << InModel({5.0, 2.0, 1.0}).transpose()
                              << " 9 9 9 0.5 1 0 2 4 3 1\n"
                              << "9 " << InModel({20.0, 4.0, -3.0}).transpose()
                              << " 9 9 9 0.5 2 1 3 2\n";
}

TEST_CASE("colmap: a model is brought into world by where its cameras were") {
  const ModelFolder folder;
  WriteModel(folder);
  const AdjustedBlock block = BlockFrom(ReadColmapModel(folder.path.string()), CamerasInWorld());
  CHECK(block.camera.cx_px == 375.5);
  CHECK(block.camera.cy_px == 239.5);
  CHECK(block.camera.fy_px == 466.0);
  REQUIRE(block.views.size() == 5);
  CHECK(block.LargestGroup() == std::vector<size_t>{0, 1, 2, 3});
  for (const size_t i : block.LargestGroup()) {
    const AdjustedView& view = block.views[i];
    const Eigen::Vector3d error =
        view.world_from_camera.translation - CamerasInWorld().at(view.frame_id);
    CHECK(error.norm() < kMaxErrorM);
    CHECK(AngleBetween(view.world_from_camera.rotation, kWorldFromCamera) < 1e-7);
  }
  REQUIRE(block.landmarks.size() == 2);
  CHECK((block.landmarks[1].point_in_world - Eigen::Vector3d(20.0, 4.0, -3.0)).norm() < kMaxErrorM);
  CHECK(block.landmarks[0].num_views == 3);
  CHECK(block.landmarks[0].height_sd_m > 0.1);
  CHECK(block.landmarks[0].height_sd_m < 2.0);
  CHECK(block.views[1].landmarks == std::vector<size_t>{0, 1});
  CHECK(block.views[0].height_above_ground == doctest::Approx(99.0));
}

TEST_CASE("colmap: too few of the photographs, and another camera, are refused") {
  const ModelFolder folder;
  WriteModel(folder);
  const ColmapModel model = ReadColmapModel(folder.path.string());
  CHECK_THROWS_AS(BlockFrom(model, {{"a.jpg", {0.0, 0.0, 0.0}}, {"b.jpg", {1.0, 0.0, 0.0}}}),
                  std::runtime_error);
  folder.File("cameras.txt") << "1 OPENCV 752 480 465 466 376 240 0 0 0 0\n";
  CHECK_THROWS_AS(ReadColmapModel(folder.path.string()), std::runtime_error);
}

}  // namespace
}  // namespace freelsd
