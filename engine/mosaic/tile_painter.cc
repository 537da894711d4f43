#include "engine/mosaic/tile_painter.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Nodes of exact projection per map cell and direction. Heights bend at the centres of map cells,
// which are nodes.
constexpr double kNodesPerMapCell = 2.0;
// Images this much finer than the mosaic are averaged first.
constexpr double kMinScale = 0.75;
// Pixels around the shown part of an image, for interpolation and for the blend at its seams.
constexpr int kPartMarginPx = 8;
// Seam cells beyond the chosen ones in which a view still has weight.
constexpr int kFeatherCells = 2;
constexpr float kMinPixelWeight = 0.004f;

// Bounding box of the seam cells for which the layer is chosen.
std::vector<cv::Rect> ChosenCells(const MosaicDesign& design) {
  std::vector<cv::Rect> boxes(design.views.size());
  for (int row = 0; row < design.chosen.rows; ++row) {
    for (int col = 0; col < design.chosen.cols; ++col) {
      const int layer = design.chosen(row, col);
      if (layer >= 0) boxes[static_cast<size_t>(layer)] |= cv::Rect(col, row, 1, 1);
    }
  }
  for (cv::Rect& box : boxes) {
    if (box.area() > 0) box += design.seam_cells.cells.tl();
  }
  return boxes;
}

cv::Rect ImagePartOf(const cv::Mat2f& pixels, const Camera& camera) {
  float left = 1e9f, top = 1e9f, right = -1e9f, bottom = -1e9f;
  for (const cv::Vec2f& pixel : pixels) {
    if (pixel[0] == kNoPixel) continue;
    left = std::min(left, pixel[0]);
    right = std::max(right, pixel[0]);
    top = std::min(top, pixel[1]);
    bottom = std::max(bottom, pixel[1]);
  }
  if (left > right) return {};
  const auto clamp = [](float at, int end) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(end)));
  };
  const cv::Point first(clamp(left - kPartMarginPx, camera.width_px),
                        clamp(top - kPartMarginPx, camera.height_px));
  const cv::Point end(clamp(right + kPartMarginPx + 2, camera.width_px),
                      clamp(bottom + kPartMarginPx + 2, camera.height_px));
  return {first, end};
}

std::vector<ImagePart> PartsOf(const MosaicDesign& design,
                               const std::vector<GroundView>& ground_views,
                               const AdjustedBlock& block,
                               double map_cell_size_m) {
  std::vector<ImagePart> parts;
  const std::vector<cv::Rect> boxes = ChosenCells(design);
  for (size_t i = 0; i < design.views.size(); ++i) {
    ImagePart part;
    part.frame_id = block.views[design.views[i]].frame_id;
    if (boxes[i].area() > 0) {
      const LatticeRect rect{design.seam_cells.size_m, Widened(boxes[i], kFeatherCells)};
      part.part =
          ImagePartOf(ground_views[i].ImageOf(rect, map_cell_size_m), ground_views[i].camera());
    }
    const double scale = ground_views[i].SamplingM() / design.lattice.pixel_size_m;
    if (scale < kMinScale) part.scale = scale;
    parts.push_back(part);
  }
  return parts;
}

// How much of each pixel's colour comes from the layer, before all layers are scaled to a sum of 1.
cv::Mat1f WeightsOf(int layer, const cv::Mat1s& chosen, int factor, int margin_px) {
  cv::Mat1f share(chosen.size());
  std::transform(chosen.begin(), chosen.end(), share.begin(), [layer](int16_t number) {
    return number == layer ? 1.0f : 0.0f;
  });
  cv::GaussianBlur(share, share, {3, 3}, 0.0, 0.0, cv::BORDER_REPLICATE);
  cv::Mat1f weights;
  cv::resize(share, weights, share.size() * factor, 0.0, 0.0, cv::INTER_LINEAR);
  weights = weights(
      cv::Rect(margin_px, margin_px, weights.cols - 2 * margin_px, weights.rows - 2 * margin_px));
  // The fourth power makes the transition narrower than a seam cell.
  weights = weights.mul(weights);
  weights = weights.mul(weights);
  // Which pixels lie in the bounding box of the rest depends on the tile.
  cv::threshold(weights, weights, kMinPixelWeight, 0.0, cv::THRESH_TOZERO);
  return weights;
}

// Sum of weighted colours, and sum of weights.
struct Accumulator {
  cv::Mat3f color;
  cv::Mat1f weight;
};

// Image positions in the loaded part; sets weights to 0 where the image does not reach.
void MoveIntoPart(const LoadedPart& loaded,
                  const Camera& camera,
                  cv::Mat2f& pixels,
                  cv::Mat1f& weights) {
  const float scale_x =
      static_cast<float>(loaded.image.cols) / static_cast<float>(loaded.part.width);
  const float scale_y =
      static_cast<float>(loaded.image.rows) / static_cast<float>(loaded.part.height);
  const auto right = static_cast<float>(camera.width_px - 1);
  const auto bottom = static_cast<float>(camera.height_px - 1);
  const auto first_x = static_cast<float>(loaded.part.x),
             first_y = static_cast<float>(loaded.part.y);
  for (int row = 0; row < pixels.rows; ++row) {
    cv::Vec2f* pixel = pixels[row];
    float* weight = weights[row];
    for (int col = 0; col < pixels.cols; ++col) {
      const float x = pixel[col][0], y = pixel[col][1];
      if (x < 0.0f || y < 0.0f || x > right || y > bottom) weight[col] = 0.0f;
      pixel[col] = {(x - first_x + 0.5f) * scale_x - 0.5f, (y - first_y + 0.5f) * scale_y - 0.5f};
    }
  }
}

void Accumulate(const cv::Mat3b& colors,
                const cv::Mat3f& factors,
                const cv::Mat1f& weights,
                cv::Mat3f sum,
                cv::Mat1f sum_of_weights) {
  for (int row = 0; row < colors.rows; ++row) {
    const cv::Vec3b* color = colors[row];
    const cv::Vec3f* factor = factors[row];
    const float* weight = weights[row];
    cv::Vec3f* out = sum[row];
    float* total = sum_of_weights[row];
    for (int col = 0; col < colors.cols; ++col) {
      for (int c = 0; c < 3; ++c) {
        out[col][c] += weight[col] * factor[col][c] * static_cast<float>(color[col][c]);
      }
      total[col] += weight[col];
    }
  }
}

cv::Mat4b Finished(const Accumulator& accumulator, const cv::Mat1b& shown) {
  cv::Mat4b tile(shown.size(), cv::Vec4b::all(0));
  bool is_empty = true;
  for (int row = 0; row < tile.rows; ++row) {
    for (int col = 0; col < tile.cols; ++col) {
      const float weight = accumulator.weight(row, col);
      if (!shown(row, col) || !(weight > kMinPixelWeight)) continue;
      const cv::Vec3f color = accumulator.color(row, col) / weight;
      tile(row, col) = {cv::saturate_cast<uint8_t>(color[0]),
                        cv::saturate_cast<uint8_t>(color[1]),
                        cv::saturate_cast<uint8_t>(color[2]),
                        255};
      is_empty = false;
    }
  }
  return is_empty ? cv::Mat4b() : tile;
}

std::vector<GroundView> GroundViewsOf(const MosaicDesign& design,
                                      const PictureGround& ground,
                                      const AdjustedBlock& block) {
  std::vector<GroundView> ground_views;
  for (const size_t view : design.views) ground_views.emplace_back(ground, block, view);
  return ground_views;
}

}  // namespace

TilePainter::TilePainter(const MosaicDesign& design,
                         const PictureGround& ground,
                         const AdjustedBlock& block,
                         const ImageSource& images,
                         double max_cache_mb)
    : design_(design),
      ground_(ground),
      ground_views_(GroundViewsOf(design, ground, block)),
      cache_(
          images, PartsOf(design, ground_views_, block, ground.grid().cell_size_m), max_cache_mb) {}

cv::Mat4b TilePainter::Paint(int row, int col) {
  const int side = design_.lattice.tile_size_px;
  const int factor = design_.pixels_per_seam_cell;
  const cv::Rect pixels(col * side, row * side, side, side);
  const LatticeRect tile{design_.lattice.pixel_size_m, pixels};
  const cv::Rect around = Widened(Coarser(pixels, factor), kFeatherCells);
  const cv::Mat1s chosen = Part(design_.chosen, design_.seam_cells.cells, around);
  if (chosen.empty()) return {};
  Accumulator accumulator{cv::Mat3f(pixels.size(), cv::Vec3f::all(0.0f)),
                          cv::Mat1f(pixels.size(), 0.0f)};
  for (const int16_t layer : std::set<int16_t>(chosen.begin(), chosen.end())) {
    if (layer < 0) continue;
    AddLayer(static_cast<size_t>(layer), chosen, tile, accumulator.color, accumulator.weight);
  }
  return Finished(accumulator, ground_.ShownCells(tile));
}

void TilePainter::AddLayer(size_t layer,
                           const cv::Mat1s& chosen,
                           const LatticeRect& tile,
                           cv::Mat3f& sum,
                           cv::Mat1f& sum_of_weights) {
  const int factor = design_.pixels_per_seam_cell;
  const cv::Mat1f weights =
      WeightsOf(static_cast<int>(layer), chosen, factor, kFeatherCells * factor);
  const cv::Rect part = cv::boundingRect(cv::Mat1b(weights > 0.0f));
  if (part.area() == 0) return;
  const LoadedPart loaded = cache_.Fetch(layer);
  if (loaded.image.empty()) return;
  const GroundView& ground_view = ground_views_[layer];
  const LatticeRect rect{tile.size_m, part + tile.cells.tl()};
  cv::Mat2f pixels = ground_view.ImageOf(rect, ground_view.cell_size_m() / kNodesPerMapCell);
  cv::Mat1f weights_of_part = weights(part).clone();
  MoveIntoPart(loaded, ground_view.camera(), pixels, weights_of_part);
  cv::Mat3b colors;
  cv::remap(loaded.image, colors, pixels, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  const BlendFactors& coarse = design_.factors[layer];
  const cv::Mat3f factors =
      Refined(coarse.factors, coarse.cells, factor * kSeamCellsPerBandCell, rect.cells);
  Accumulate(colors, factors, weights_of_part, sum(part), sum_of_weights(part));
}

}  // namespace freelsd
