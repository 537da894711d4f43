#include "tests/evaluation/pictures.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kPixelsPerMetre = 1.8;

// A square picture of the world, north up.
class Canvas {
 public:
  explicit Canvas(double size_m)
      : size_m_(size_m),
        image_(static_cast<int>(size_m * kPixelsPerMetre),
               static_cast<int>(size_m * kPixelsPerMetre),
               cv::Vec3b(0, 0, 0)) {}

  cv::Mat3b& image() { return image_; }
  Eigen::Vector2d PlaceOf(int row, int col) const {
    return {(col + 0.5) / kPixelsPerMetre - 0.5 * size_m_,
            0.5 * size_m_ - (row + 0.5) / kPixelsPerMetre};
  }
  cv::Point PixelOf(const Eigen::Vector2d& place) const {
    return {static_cast<int>((place.x() + 0.5 * size_m_) * kPixelsPerMetre),
            static_cast<int>((0.5 * size_m_ - place.y()) * kPixelsPerMetre)};
  }
  template <typename ColorOf>
  void Fill(ColorOf color_of) {
    for (int row = 0; row < image_.rows; ++row) {
      for (int col = 0; col < image_.cols; ++col) image_(row, col) = color_of(PlaceOf(row, col));
    }
  }
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const cv::Scalar& color) {
    cv::line(image_, PixelOf(from), PixelOf(to), color, 2, cv::LINE_AA);
  }
  void Circle(const Eigen::Vector2d& center, double radius_m, const cv::Scalar& color) {
    cv::circle(image_,
               PixelOf(center),
               static_cast<int>(radius_m * kPixelsPerMetre),
               color,
               1,
               cv::LINE_AA);
  }
  void Text(const Eigen::Vector2d& place, const std::string& text) {
    cv::putText(image_,
                text,
                PixelOf(place),
                cv::FONT_HERSHEY_SIMPLEX,
                0.4,
                {255, 255, 255},
                1,
                cv::LINE_AA);
  }

 private:
  double size_m_;
  cv::Mat3b image_;
};

cv::Scalar ColorOf(Verdict verdict) {
  if (verdict == Verdict::kLandable) return {80, 255, 80};
  if (verdict == Verdict::kUnverified) return {0, 230, 255};
  return {60, 60, 255};
}

void DrawSites(Canvas& canvas, const Scenario& scenario, const EngineRun& run) {
  for (const Site& site : run.evaluation.sites) {
    const cv::Scalar color = ColorOf(site.plan.verdict);
    const Polygon footprint = site.region.Footprint();
    for (size_t i = 0; i < footprint.size(); ++i) {
      canvas.Line(footprint[i], footprint[(i + 1) % footprint.size()], color * 0.6);
    }
    const Eigen::Vector2d touchdown = site.plan.touchdown_in_world.head<2>();
    canvas.Circle(touchdown, scenario.aircraft.touchdown_uncertainty_m, {255, 255, 255});
    canvas.Text(touchdown, std::to_string(site.region.id));
    if (!site.plan.approach) continue;
    const Approach& approach = *site.plan.approach;
    canvas.Line(approach.approach_start_in_world.head<2>(), touchdown, color);
    canvas.Line(touchdown,
                touchdown + scenario.aircraft.ground_roll_m * DirectionOf(approach.heading),
                color * 0.8);
    if (site.plan.verdict != Verdict::kRejected) {
      canvas.Circle(approach.loiter_center_in_world.head<2>(), approach.loiter_radius, color * 0.7);
    }
  }
}

cv::Vec3b FaultColor(const TruthMap& truth, const Fields& fields, const cv::Point& cell) {
  const int id = fields.label(cell);
  switch (static_cast<GroundFault>(truth.fault(cell))) {
    case GroundFault::kNone:
      if (id == 0) return {110, 150, 110};
      return fields.fields[static_cast<size_t>(id - 1)].is_landable ? cv::Vec3b(60, 190, 60)
                                                                    : cv::Vec3b(60, 160, 190);
    case GroundFault::kSteep:
      return {160, 90, 160};
    case GroundFault::kRough:
      return {60, 110, 150};
    default:
      return {70, 70, 70};
  }
}

cv::Vec3b HazardColor(const Evaluation& evaluation, const Eigen::Vector2d& place) {
  const auto cell = evaluation.hazards.grid.CellAt(place);
  if (!cell) return {0, 0, 0};
  const uint8_t hazard = evaluation.hazards.hazard(*cell);
  if (hazard == kUnseen) return {40, 40, 40};
  if (hazard == kFree) return {60, 160, 60};
  const float grass = evaluation.hazards.grass(*cell);
  // Hazard by class is grey, on grass (too steep, too rough, something stands there) violet.
  return grass >= 0.5f ? cv::Vec3b(170, 60, 150) : cv::Vec3b(110, 110, 120);
}

cv::Vec3b HeightColor(const ElevationMap& map, const Eigen::Vector2d& place) {
  const auto cell = map.grid.CellAt(place);
  if (!cell || !map.IsSeen(cell->y, cell->x)) return {60, 0, 60};
  constexpr float kGreyPerMetre = 8.0f;
  const uint8_t grey = cv::saturate_cast<uint8_t>(100.0f + kGreyPerMetre * map.elevation(*cell));
  const uint8_t upper = cv::saturate_cast<uint8_t>(100.0f + kGreyPerMetre * map.upper(*cell));
  return {grey, grey, upper};
}

void Save(Canvas& canvas, const std::string& path, const Scenario& scenario, const EngineRun& run) {
  DrawSites(canvas, scenario, run);
  if (!cv::imwrite(path, canvas.image())) throw std::runtime_error("cannot write " + path);
}

}  // namespace

void DrawWorld(const std::string& folder,
               const std::string& name,
               const Scenario& scenario,
               const EngineRun& run,
               const TruthMap& truth,
               const Fields& fields) {
  std::filesystem::create_directories(folder);
  const std::string stem = (std::filesystem::path(folder) / name).string();
  const World& world = scenario.world;
  Canvas photograph(world.size_m);
  photograph.Fill([&](const Eigen::Vector2d& place) {
    return world.radiance(world.CellIndex(place.y()), world.CellIndex(place.x()));
  });
  Save(photograph, stem + "-world.png", scenario, run);
  Canvas faults(world.size_m);
  faults.Fill([&](const Eigen::Vector2d& place) {
    const cv::Point cell = truth.CellAt(place);
    return FaultColor(truth, fields, cell) * (scenario.seen(cell) != 0 ? 1.0 : 0.5);
  });
  for (const Field& field : fields.fields) faults.Text(field.touchdown, std::to_string(field.id));
  Save(faults, stem + "-truth.png", scenario, run);
  Canvas hazards(world.size_m);
  hazards.Fill([&](const Eigen::Vector2d& place) { return HazardColor(run.evaluation, place); });
  Save(hazards, stem + "-hazard.png", scenario, run);
  Canvas heights(world.size_m);
  heights.Fill(
      [&](const Eigen::Vector2d& place) { return HeightColor(run.evaluation.map, place); });
  Save(heights, stem + "-elevation.png", scenario, run);
}

}  // namespace freelsd
