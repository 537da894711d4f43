#include "engine/mosaic/view_layer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Nearer to the border, a remapped pixel would use pixels beyond it.
constexpr float kMinBorderDistancePx = 4.0f;
constexpr double kLargestCost = kNotShown - 1.0;
constexpr double kDetailScale = 4.0;

float BorderDistancePx(const Camera& camera, const cv::Vec2f& pixel) {
  return std::min(std::min(pixel[0], static_cast<float>(camera.width_px - 1) - pixel[0]),
                  std::min(pixel[1], static_cast<float>(camera.height_px - 1) - pixel[1]));
}

// Whether ground between the place and the eye is higher than the ray. Looks as far as the highest
// ground could hide the place.
bool IsHidden(const PictureGround& ground,
              const Eigen::Vector3d& place,
              const Eigen::Vector3d& eye,
              double hidden_height_m) {
  const Eigen::Vector3d ray = (eye - place) / (eye.z() - place.z());
  const double step_m = ground.grid().cell_size_m;
  const double run = ray.head<2>().norm();
  const double reach_m = run * (ground.HighestHeight() - place.z() - hidden_height_m);
  for (double at_m = step_m; at_m < reach_m; at_m += step_m) {
    const Eigen::Vector3d on_ray = place + ray * (at_m / run);
    if (ground.HeightAt(on_ray.head<2>()) > on_ray.z() + hidden_height_m) return true;
  }
  return false;
}

class CostOfView {
 public:
  CostOfView(const PictureGround& ground,
             const GroundView& ground_view,
             const MosaicOptions& options)
      : ground_(ground),
        camera_(ground_view.camera()),
        eye_(ground_view.position_in_world()),
        options_(options),
        border_px_(static_cast<float>(options.border_ratio) *
                   static_cast<float>(std::min(camera_.width_px, camera_.height_px))) {}

  uint8_t At(const Eigen::Vector2d& place_in_world, const cv::Vec2f& pixel) const {
    const float distance_px = BorderDistancePx(camera_, pixel);
    if (distance_px < kMinBorderDistancePx) return kNotShown;
    Eigen::Vector3d place;
    place << place_in_world, ground_.HeightAt(place_in_world);
    const double height = eye_.z() - place.z();
    if (!(height > 0.0)) return kNotShown;
    const double squared_tangent = (eye_ - place).head<2>().squaredNorm() / (height * height);
    const double closeness = std::max(0.0f, 1.0f - distance_px / std::max(border_px_, 1.0f));
    double cost =
        options_.steepness_cost * squared_tangent + options_.border_cost * closeness * closeness;
    if (options_.hidden_cost > 0.0 && IsHidden(ground_, place, eye_, options_.hidden_height_m)) {
      cost += options_.hidden_cost;
    }
    return static_cast<uint8_t>(std::lround(std::min(cost, kLargestCost)));
  }

 private:
  const PictureGround& ground_;
  const Camera& camera_;
  const Eigen::Vector3d eye_;
  const MosaicOptions& options_;
  const float border_px_;
};

cv::Mat1b CostsOf(const PictureGround& ground,
                  const GroundView& ground_view,
                  const LatticeRect& rect,
                  const MosaicOptions& options) {
  const CostOfView cost(ground, ground_view, options);
  const cv::Mat1b shown = ground.ShownCells(rect);
  const cv::Mat2f pixels = ground_view.ImageOf(rect, ground.grid().cell_size_m);
  cv::Mat1b costs(shown.size(), kNotShown);
  for (int row = 0; row < costs.rows; ++row) {
    for (int col = 0; col < costs.cols; ++col) {
      if (!shown(row, col)) continue;
      costs(row, col) = cost.At(rect.CellCenter(row, col), pixels(row, col));
    }
  }
  return costs;
}

// The highest cost that is still among the `count` lowest of each cell; kNotShown where fewer
// views show the cell. Ties are broken later, by the order of the layers.
class BestOfCell {
 public:
  BestOfCell(const cv::Rect& cells, int count)
      : cells_(cells),
        count_(count),
        costs_(cells.height, cells.width * count, kNotShown),
        layers_(cells.height, cells.width * count, int16_t{-1}) {}

  void Offer(int layer, const cv::Point& cell, uint8_t cost) {
    const cv::Point at = cell - cells_.tl();
    uint8_t* costs = costs_[at.y] + at.x * count_;
    int16_t* layers = layers_[at.y] + at.x * count_;
    auto number = static_cast<int16_t>(layer);
    for (int i = 0; i < count_; ++i) {
      if (cost >= costs[i]) continue;
      std::swap(cost, costs[i]);
      std::swap(number, layers[i]);
    }
  }
  bool Has(int layer, const cv::Point& cell) const {
    const cv::Point at = cell - cells_.tl();
    const int16_t* layers = layers_[at.y] + at.x * count_;
    return std::find(layers, layers + count_, layer) != layers + count_;
  }

 private:
  cv::Rect cells_;
  int count_;
  cv::Mat1b costs_;
  cv::Mat1s layers_;
};

template <typename Visit>
void ForEachCell(const cv::Rect& cells, Visit visit) {
  for (int row = cells.y; row < cells.br().y; ++row) {
    for (int col = cells.x; col < cells.br().x; ++col) visit(cv::Point(col, row));
  }
}

// Scaled so that a pixel is about as large on the ground as `size_m`.
cv::Mat Shrunk(const cv::Mat& image, double factor) {
  if (factor >= 1.0) return image;
  cv::Mat shrunk;
  cv::resize(image, shrunk, {}, factor, factor, cv::INTER_AREA);
  return shrunk;
}

cv::Mat Remapped(const cv::Mat& shrunk, const cv::Size& size, const cv::Mat2f& pixels) {
  const cv::Scalar factor(static_cast<double>(shrunk.cols) / size.width,
                          static_cast<double>(shrunk.rows) / size.height);
  cv::Mat scaled;
  cv::multiply(pixels + cv::Scalar(0.5, 0.5), factor, scaled);
  cv::Mat result;
  cv::remap(
      shrunk, result, scaled - cv::Scalar(0.5, 0.5), {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace

bool IsUsable(const cv::Mat& image, const Camera& camera) {
  return !image.empty() && (image.type() == CV_8UC3 || image.type() == CV_8UC1) &&
         image.size() == cv::Size(camera.width_px, camera.height_px);
}

cv::Mat3b AsColor(const cv::Mat& image) {
  if (image.channels() == 3) return image;
  cv::Mat3b color;
  cv::cvtColor(image, color, cv::COLOR_GRAY2BGR);
  return color;
}

std::vector<ViewLayer> LayersOf(const PictureGround& ground,
                                const AdjustedBlock& block,
                                const LatticeRect& seam_cells,
                                const std::vector<bool>& is_wanted,
                                const MosaicOptions& options) {
  std::vector<ViewLayer> layers;
  for (size_t v = 0; v < block.views.size(); ++v) {
    if (!block.views[v].is_connected || !is_wanted[v]) continue;
    const GroundView ground_view(ground, block, v);
    ViewLayer layer;
    layer.view = v;
    layer.cells = ground_view.CellsWithin(seam_cells);
    if (layer.cells.area() == 0) continue;
    layer.cost = CostsOf(ground, ground_view, {seam_cells.size_m, layer.cells}, options);
    layers.push_back(std::move(layer));
  }
  return layers;
}

std::vector<ViewLayer> WithCandidates(std::vector<ViewLayer> layers,
                                      const LatticeRect& seam_cells,
                                      int margin_cells,
                                      const MosaicOptions& options) {
  BestOfCell best(seam_cells.cells, options.max_num_candidates);
  for (size_t i = 0; i < layers.size(); ++i) {
    ForEachCell(layers[i].cells, [&](const cv::Point& cell) {
      const uint8_t cost = layers[i].cost(cell - layers[i].cells.tl());
      if (cost != kNotShown) best.Offer(static_cast<int>(i), cell, cost);
    });
  }
  std::vector<ViewLayer> kept;
  for (size_t i = 0; i < layers.size(); ++i) {
    ViewLayer& layer = layers[i];
    const cv::Point first = layer.cells.tl();
    layer.is_candidate = cv::Mat1b(layer.cost.size(), uint8_t{0});
    ForEachCell(layer.cells, [&](const cv::Point& cell) {
      if (best.Has(static_cast<int>(i), cell)) layer.is_candidate(cell - first) = 255;
    });
    const cv::Rect used = cv::boundingRect(layer.is_candidate);
    if (used.area() == 0) continue;
    const cv::Rect part = Widened(used, margin_cells) & cv::Rect(cv::Point(), layer.cost.size());
    layer.cost = layer.cost(part).clone();
    layer.is_candidate = layer.is_candidate(part).clone();
    layer.cells = part + first;
    kept.push_back(std::move(layer));
  }
  return kept;
}

void AddPicture(const cv::Mat& image,
                const GroundView& ground_view,
                double seam_cell_size_m,
                ViewLayer& layer) {
  const LatticeRect rect{seam_cell_size_m, layer.cells};
  const cv::Mat2f pixels = ground_view.ImageOf(rect, ground_view.cell_size_m());
  const double factor = ground_view.SamplingM() / seam_cell_size_m;
  const cv::Mat3b shrunk = AsColor(Shrunk(image, factor));
  layer.picture = Remapped(shrunk, image.size(), pixels);
  cv::Mat grey, laplacian, contrast;
  if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = image;
  }
  cv::Laplacian(grey, laplacian, CV_16S, 1);
  cv::convertScaleAbs(laplacian, contrast, kDetailScale);
  layer.detail = Remapped(Shrunk(contrast, factor), image.size(), pixels);
}

}  // namespace freelsd
