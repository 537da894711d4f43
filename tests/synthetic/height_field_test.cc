#include "tests/synthetic/height_field.h"

#include <doctest/doctest.h>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/renderer.h"
#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

World SmallFarmland() {
  WorldOptions options;
  options.size_m = 300.0;
  options.cell_size_m = 0.5;
  return MakeFarmland(options);
}

TEST_CASE("height field: many rays started together meet what each of them meets in small steps") {
  constexpr double kStepM = 0.02;
  constexpr double kMaxErrorM = 0.06;
  const World world = SmallFarmland();
  const HeightField field(world.surface);
  const Eigen::Vector3d origin(world.CellFrom(-20.0), world.CellFrom(10.0), 90.0);
  int num_apart = 0, num_rays = 0;
  for (double east = -2.0; east <= 2.0; east += 0.16) {
    for (double north = -2.0; north <= 2.0; north += 0.16) {
      const Eigen::Vector2d first(east, north), last(east + 0.06, north + 0.06);
      const HeightRange layer = field.LayerMetBy(origin, Eigen::AlignedBox2d(first).extend(last));
      for (const Eigen::Vector2d& slide : {first, last}) {
        double z = origin.z();
        const auto surface_under = [&] {
          const Eigen::Vector2d cell = origin.head<2>() + (origin.z() - z) * slide;
          return Bilinear(world.surface, cell.x(), cell.y());
        };
        while (z > surface_under()) z -= kStepM;
        CHECK(z < layer.top + kMaxErrorM);
        CHECK(z > layer.bottom - kMaxErrorM);
        const float depth = field.HitDepth(DescentThrough(layer, origin, slide));
        num_apart += std::abs(layer.top - depth - z) > kMaxErrorM;
        ++num_rays;
      }
    }
  }
  // Steps of half a cell may pass the rim of a crown that small steps graze.
  CHECK(num_rays > 1000);
  CHECK(num_apart < 0.01 * num_rays);
}

TEST_CASE("height field: level ground is one height, and rays beyond the edge meet it too") {
  const HeightField field(cv::Mat1f(40, 40, 3.0f));
  const Eigen::Vector3d origin(-60.0, 100.0, 20.0);
  const Eigen::AlignedBox2d slides(Eigen::Vector2d(-1.0, -1.0), Eigen::Vector2d(2.0, 1.0));
  const HeightRange layer = field.LayerMetBy(origin, slides);
  CHECK(layer.top == 3.0f);
  CHECK(layer.bottom == 3.0f);
  CHECK(field.HitDepth(DescentThrough(layer, origin, slides.min())) == 0.0f);
}

TEST_CASE("renderer: the number of threads changes no byte") {
  const World world = SmallFarmland();
  const Renderer renderer(world);
  const Camera camera = PaperCamera(188, 120);
  AutopilotSample sample;
  sample.position_in_world = {5.0, 5.0, 80.0};
  const Rigid3d world_from_camera = WorldFromBody(sample) * Rig{}.body_from_camera;
  const int num_threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat image = renderer.Render(camera, world_from_camera, RenderOptions{}, 0);
  cv::setNumThreads(2);
  const cv::Mat again = renderer.Render(camera, world_from_camera, RenderOptions{}, 0);
  cv::setNumThreads(num_threads);
  CHECK(cv::norm(image, again, cv::NORM_INF) == 0.0);
}

}  // namespace
}  // namespace freelsd
