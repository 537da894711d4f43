#include "tests/evaluation/curves.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

using Curve = std::vector<cv::Point2d>;

constexpr int kWidthPx = 720;
constexpr int kHeightPx = 240;
constexpr int kMarginPx = 36;

const std::vector<cv::Scalar> kColors{
    {80, 220, 80}, {255, 160, 60}, {60, 200, 255}, {220, 100, 220}, {220, 220, 80}, {80, 80, 255}};

// Ends of an axis, with room where all values are one.
struct Span {
  double low = 0.0;
  double high = 1.0;
};

Span SpanOf(const std::vector<Curve>& curves, double cv::Point2d::*coordinate) {
  Span span{1e300, -1e300};
  for (const Curve& curve : curves) {
    for (const cv::Point2d& point : curve) {
      if (!std::isfinite(point.*coordinate)) continue;
      span.low = std::min(span.low, point.*coordinate);
      span.high = std::max(span.high, point.*coordinate);
    }
  }
  if (span.low > span.high) return {};
  if (span.high - span.low < 1e-9) span.high = span.low + 1.0;
  return span;
}

void Write(cv::Mat3b& panel, const cv::Point& place, const std::string& text) {
  cv::putText(panel, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.4, {200, 200, 200}, 1, cv::LINE_AA);
}

std::string Short(double value) { return cv::format("%.4g", value); }

// Curves in one frame with the ends of its axes; gaps where a value is not finite.
cv::Mat3b Panel(const std::string& title, const std::vector<Curve>& curves, Span x, Span y) {
  cv::Mat3b panel(kHeightPx, kWidthPx, cv::Vec3b(30, 30, 30));
  const cv::Rect frame(kMarginPx, kMarginPx, kWidthPx - 2 * kMarginPx, kHeightPx - 2 * kMarginPx);
  cv::rectangle(panel, frame, {110, 110, 110});
  const auto pixel = [&](const cv::Point2d& point) {
    return cv::Point(
        frame.x + static_cast<int>((point.x - x.low) / (x.high - x.low) * frame.width),
        frame.y + static_cast<int>((y.high - point.y) / (y.high - y.low) * frame.height));
  };
  for (size_t i = 0; i < curves.size(); ++i) {
    const cv::Scalar& color = kColors[i % kColors.size()];
    for (size_t j = 1; j < curves[i].size(); ++j) {
      const cv::Point2d &from = curves[i][j - 1], &to = curves[i][j];
      if (!std::isfinite(from.y) || !std::isfinite(to.y)) continue;
      cv::line(panel, pixel(from), pixel(to), color, 1, cv::LINE_AA);
    }
  }
  Write(panel, {kMarginPx, kMarginPx - 8}, title + "   " + Short(y.low) + " to " + Short(y.high));
  Write(panel, {kMarginPx, kHeightPx - 12}, Short(x.low));
  Write(panel, {kWidthPx - kMarginPx - 30, kHeightPx - 12}, Short(x.high));
  return panel;
}

void Save(const std::string& folder, const std::string& name, const cv::Mat& picture) {
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/" + name + ".png";
  if (!cv::imwrite(path, picture)) throw std::runtime_error("cannot write " + path);
}

cv::Mat3b RegionPanel(const std::string& title,
                      const EngineRun& run,
                      double (*value)(const RegionHistory&)) {
  std::map<std::string, int> number_of_frame;
  for (size_t i = 0; i < run.snapshot.views.size(); ++i) {
    number_of_frame[run.snapshot.views[i].frame_id] = static_cast<int>(i);
  }
  std::vector<Curve> curves;
  for (const Region& region : run.regions) {
    if (region.grade <= 0.0) continue;
    Curve curve;
    for (const RegionHistory& state : region.history) {
      curve.emplace_back(number_of_frame[state.frame_id], value(state));
    }
    curves.push_back(curve);
  }
  const Span frames{0.0, std::max<double>(1.0, static_cast<double>(run.snapshot.views.size()))};
  return Panel(title, curves, frames, SpanOf(curves, &cv::Point2d::y));
}

double ShareOfGrass(const RegionHistory& state) {
  return static_cast<double>(state.num_grass_observations) / std::max(state.num_observations, 1);
}
double NumObservations(const RegionHistory& state) { return state.num_observations; }
double Area(const RegionHistory& state) { return state.area_m2; }
double Grade(const RegionHistory& state) { return state.grade; }

void DrawRegions(const std::string& folder, const std::string& name, const EngineRun& run) {
  const std::vector<cv::Mat> panels{RegionPanel("observations", run, NumObservations),
                                    RegionPanel("share of grass", run, ShareOfGrass),
                                    RegionPanel("area, m2", run, Area),
                                    RegionPanel("grade", run, Grade)};
  cv::Mat picture;
  cv::vconcat(panels, picture);
  Save(folder, name + "-regions", picture);
}

}  // namespace

void DrawRoc(const std::string& folder, const std::string& name, const RocCounts& counts) {
  double all_true = 0.0, all_false = 0.0;
  for (int i = 0; i < RocCounts::kNumBins; ++i) {
    all_true += static_cast<double>(counts.num_true[static_cast<size_t>(i)]);
    all_false += static_cast<double>(counts.num_false[static_cast<size_t>(i)]);
  }
  if (all_true == 0.0 || all_false == 0.0) return;
  Curve roc{{0.0, 0.0}}, precision;
  double true_above = 0.0, false_above = 0.0;
  for (int i = RocCounts::kNumBins - 1; i >= 0; --i) {
    true_above += static_cast<double>(counts.num_true[static_cast<size_t>(i)]);
    false_above += static_cast<double>(counts.num_false[static_cast<size_t>(i)]);
    roc.emplace_back(false_above / all_false, true_above / all_true);
    if (true_above + false_above == 0.0) continue;
    precision.emplace_back(true_above / all_true, true_above / (true_above + false_above));
  }
  Save(folder,
       name + "-roc",
       Panel("ROC, area " + Short(counts.Auc()) + "; precision over recall",
             {roc, precision},
             Span{},
             Span{}));
}

void DrawCurves(const std::string& folder, const std::string& name, const EngineRun& run) {
  DrawRegions(folder, name, run);
  for (const Site& site : run.evaluation.sites) {
    if (!site.plan.approach) continue;
    const ApproachProfile& profile = site.plan.approach->profile;
    Curve ground, path;
    for (size_t i = 0; i < profile.distance.size(); ++i) {
      // Flown from left to right.
      ground.emplace_back(-profile.distance[i], profile.terrain_height[i]);
      path.emplace_back(-profile.distance[i], profile.path_height[i]);
    }
    const std::vector<Curve> curves{ground, path};
    Save(folder,
         name + "-profile-" + std::to_string(site.region.id),
         Panel("highest ground in the corridor and path, m",
               curves,
               SpanOf(curves, &cv::Point2d::x),
               SpanOf(curves, &cv::Point2d::y)));
  }
}

}  // namespace freelsd
