#include "tests/evaluation/fields/field_pictures.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/evaluation/fields/ground_projection.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;
using Sites = std::vector<DistinctSite>;

// Pixels of a photograph that one value of the tint covers.
constexpr int kTintSidePx = 6;
constexpr int kMaxWidthPx = 1400;

cv::Scalar ColorOf(OutlineKind kind) {
  switch (kind) {
    case OutlineKind::kLand:
      return {80, 255, 80};
    case OutlineKind::kRefuse:
      return {60, 60, 255};
    case OutlineKind::kDoubt:
      return {190, 190, 190};
    default:
      return {0, 160, 255};
  }
}

cv::Scalar ColorOf(Finding finding) {
  switch (finding) {
    case Finding::kRight:
      return {255, 255, 255};
    case Finding::kNotJudged:
      return {0, 255, 255};
    case Finding::kFalseSafe:
      break;
  }
  return {255, 0, 255};
}

// A line on the ground, closed or not.
struct GroundLine {
  Polygon points;
  bool is_closed = true;
  double raise_m = 0.0;
};

// Disc, roll and final.
std::vector<GroundLine> LinesOf(const Approach& approach, const Aircraft& aircraft) {
  constexpr int kNumCirclePoints = 36, kNumFinalPoints = 30;
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const Eigen::Vector2d start = approach.approach_start_in_world.head<2>();
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const Eigen::Vector2d across =
      aircraft.path_half_width_m * Eigen::Vector2d(forward.y(), -forward.x());
  const Eigen::Vector2d end = touchdown + aircraft.ground_roll_m * forward;
  GroundLine disc, final_path{{}, false, 0.0};
  for (int i = 0; i < kNumCirclePoints; ++i) {
    disc.points.push_back(touchdown + aircraft.touchdown_uncertainty_m *
                                          DirectionOf(2.0 * kPi * i / kNumCirclePoints));
  }
  for (int i = 0; i <= kNumFinalPoints; ++i) {
    final_path.points.push_back(start + (touchdown - start) * (double(i) / kNumFinalPoints));
  }
  return {disc,
          {{touchdown + across, end + across, end - across, touchdown - across}, true, 0.0},
          final_path};
}

// One photograph to draw on.
class Canvas {
 public:
  Canvas(const cv::Mat& image, const GroundProjection& projection, size_t view)
      : projection_(projection), view_(view) {
    if (image.channels() == 1) {
      cv::cvtColor(image, image_, cv::COLOR_GRAY2BGR);
    } else {
      image_ = image.clone();
    }
  }

  void Tint(const HazardLayers& hazards) {
    for (int row = 0; row < image_.rows; row += kTintSidePx) {
      for (int col = 0; col < image_.cols; col += kTintSidePx) {
        const auto ground = projection_.GroundAt(view_, {double(col), double(row)});
        if (!ground) continue;
        const auto cell = hazards.grid.CellAt(ground->head<2>());
        const uint8_t hazard = cell ? hazards.hazard(*cell) : uint8_t{kUnseen};
        const cv::Scalar color = hazard == kFree     ? cv::Scalar(0, 200, 0)
                                 : hazard == kHazard ? cv::Scalar(0, 0, 255)
                                                     : cv::Scalar(0, 0, 0);
        cv::Mat square =
            image_(cv::Rect(col, row, kTintSidePx, kTintSidePx) & cv::Rect({}, image_.size()));
        constexpr double kTintShare = 0.35;
        square = (1.0 - kTintShare) * square + kTintShare * color;
      }
    }
  }
  void DrawOnGround(const GroundLine& line, const cv::Scalar& color, int thickness) {
    const size_t count = line.points.size() - (line.is_closed ? 0 : 1);
    for (size_t i = 0; i < count; ++i) {
      const auto from = projection_.PixelOf(view_, line.points[i], line.raise_m);
      const auto to =
          projection_.PixelOf(view_, line.points[(i + 1) % line.points.size()], line.raise_m);
      if (from && to) Line(*from, *to, color, thickness);
    }
  }
  void Write(const Eigen::Vector2d& place, const std::string& text, const cv::Scalar& color) {
    const auto pixel = projection_.PixelOf(view_, place);
    if (!pixel) return;
    const cv::Point at(static_cast<int>(pixel->x()), static_cast<int>(pixel->y()));
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.7, {0, 0, 0}, 4, cv::LINE_AA);
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.7, color, 2, cv::LINE_AA);
  }
  void Save(const fs::path& path) const {
    const double factor = std::min(1.0, double(kMaxWidthPx) / image_.cols);
    cv::Mat scaled;
    cv::resize(image_, scaled, {}, factor, factor, cv::INTER_AREA);
    cv::imwrite(path.string(), scaled);
  }

 private:
  void Line(const Eigen::Vector2d& from,
            const Eigen::Vector2d& to,
            const cv::Scalar& color,
            int thickness) {
    cv::line(image_,
             {static_cast<int>(from.x()), static_cast<int>(from.y())},
             {static_cast<int>(to.x()), static_cast<int>(to.y())},
             color,
             thickness,
             cv::LINE_AA);
  }

  const GroundProjection& projection_;
  size_t view_;
  cv::Mat image_;
};

void DrawSite(const DistinctSite& site, const Aircraft& aircraft, Canvas* canvas) {
  const cv::Scalar color = ColorOf(site.finding);
  for (const GroundLine& line : LinesOf(site.shown.approach, aircraft)) {
    canvas->DrawOnGround(line, color, 2);
  }
  std::string text = site.shown.judgement.cause;
  if (!text.empty()) text += " " + site.shown.judgement.object_id;
  canvas->Write(site.shown.approach.touchdown_in_world.head<2>(), text, color);
}

void DrawLabels(const FieldSurvey& survey, const std::string& photograph, Canvas* canvas) {
  for (const LabelledObject& object : survey.ground.objects) {
    for (const GroundOutline& view : object.views) {
      const int thickness = view.photograph == photograph ? 3 : 1;
      canvas->DrawOnGround({view.outline, true, view.raise_m}, ColorOf(object.kind), thickness);
    }
    if (object.kind == OutlineKind::kLand) continue;
    canvas->Write(object.views.front().outline.front(), object.id, ColorOf(object.kind));
  }
  for (const FieldResult& result : survey.fields) {
    canvas->Write(result.field.middle,
                  result.field.id + ": " + (result.IsField() ? result.fate : "does not fit"),
                  ColorOf(OutlineKind::kLand));
  }
}

// The view in which most points of disc, roll and final appear.
std::optional<size_t> BestView(const GroundProjection& projection,
                               const AdjustedBlock& block,
                               const std::vector<GroundLine>& lines) {
  std::optional<size_t> best;
  int most = 0;
  for (size_t view = 0; view < block.views.size(); ++view) {
    if (!block.views[view].is_connected) continue;
    int count = 0;
    for (const GroundLine& line : lines) {
      for (const Eigen::Vector2d& point : line.points) {
        count += projection.PixelOf(view, point).has_value();
      }
    }
    if (count <= most) continue;
    most = count;
    best = view;
  }
  return best;
}

const cv::Mat& ImageOf(const std::vector<Frame>& frames, const std::string& id) {
  return std::find_if(
             frames.begin(), frames.end(), [&](const Frame& frame) { return frame.id == id; })
      ->image;
}

class Painter {
 public:
  Painter(const FieldSurvey& survey, const std::vector<Frame>& frames)
      : survey_(survey),
        frames_(frames),
        projection_(survey.run.evaluation.block, survey.ground.bare_heights) {}

  const GroundProjection& projection() const { return projection_; }
  void DrawView(size_t view, bool is_tinted, const Sites& sites, const fs::path& path) const {
    const Evaluation& evaluation = survey_.run.evaluation;
    const std::string& id = evaluation.block.views[view].frame_id;
    Canvas canvas(ImageOf(frames_, id), projection_, view);
    if (is_tinted) canvas.Tint(evaluation.hazards);
    DrawLabels(survey_, fs::path(id).stem().string(), &canvas);
    for (const DistinctSite& site : sites) DrawSite(site, survey_.aircraft, &canvas);
    canvas.Save(path);
  }
  void DrawSites(const Sites& sites, const fs::path& folder, const std::string& prefix) const {
    for (size_t i = 0; i < sites.size(); ++i) {
      const auto lines = LinesOf(sites[i].shown.approach, survey_.aircraft);
      const auto view = BestView(projection_, survey_.run.evaluation.block, lines);
      if (!view) continue;
      const std::string number = (i < 9 ? "0" : "") + std::to_string(i + 1);
      DrawView(*view, false, sites, folder / (prefix + "site-" + number + ".png"));
    }
  }

 private:
  const FieldSurvey& survey_;
  const std::vector<Frame>& frames_;
  GroundProjection projection_;
};

// At most as many as a person looks at.
Sites FirstFalseSafe(const Sites& sites) {
  constexpr size_t kMaxNumSites = 6;
  Sites first;
  std::copy_if(sites.begin(), sites.end(), std::back_inserter(first), [](const auto& site) {
    return site.finding == Finding::kFalseSafe;
  });
  if (first.size() > kMaxNumSites) first.resize(kMaxNumSites);
  return first;
}

}  // namespace

void DrawSurvey(const std::string& folder,
                const FieldSurvey& survey,
                const std::vector<Frame>& frames) {
  fs::create_directories(folder);
  const Painter painter(survey, frames);
  std::set<std::string> photographs;
  for (const LabelledObject& object : survey.ground.objects) {
    for (const GroundOutline& view : object.views) photographs.insert(view.photograph);
  }
  for (const std::string& photograph : photographs) {
    const size_t view = *painter.projection().ViewOf(photograph);
    painter.DrawView(view, false, survey.sites, fs::path(folder) / (photograph + ".png"));
    painter.DrawView(view, true, survey.sites, fs::path(folder) / (photograph + "-map.png"));
  }
  painter.DrawSites(survey.sites, folder, "");
  for (const auto& [name, sites] : survey.sites_on_labels) {
    painter.DrawSites(FirstFalseSafe(sites), folder, "blind-" + name + "-");
  }
}

}  // namespace freelsd
