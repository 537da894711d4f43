#include "engine/mosaic/blending.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Larger factors are no difference of light but an object that only one view shows there.
constexpr float kMaxFactor = 1.6f;
// Grey levels are added to both parts of the ratio, because dark values are mostly noise.
constexpr float kDarkLevel = 4.0f;
constexpr float kMinWeight = 1e-4f;

struct Band {
  cv::Rect cells;
  // Gaussian mean of the picture.
  cv::Mat3f slow;
  // Where the picture is known; how much the layer is chosen, less towards its edge.
  cv::Mat1f weight;
};

// Mean of the picture over band cells, and the share of their area that it covers; how much of the
// area the layer is chosen in.
struct Averages {
  cv::Rect cells;
  cv::Mat3f sum;
  cv::Mat1f share;
  cv::Mat1f chosen_share;
};

Averages AveragesOf(const ViewLayer& layer,
                    int number,
                    const cv::Mat1s& chosen,
                    const LatticeRect& seam_cells) {
  constexpr float kArea = kSeamCellsPerBandCell * kSeamCellsPerBandCell;
  Averages averages;
  averages.cells = Coarser(layer.cells, kSeamCellsPerBandCell);
  averages.sum = cv::Mat3f(averages.cells.size(), cv::Vec3f::all(0.0f));
  averages.share = cv::Mat1f(averages.cells.size(), 0.0f);
  averages.chosen_share = cv::Mat1f(averages.cells.size(), 0.0f);
  for (int row = 0; row < layer.cost.rows; ++row) {
    for (int col = 0; col < layer.cost.cols; ++col) {
      if (layer.cost(row, col) == kNotShown) continue;
      const cv::Point cell = layer.cells.tl() + cv::Point(col, row);
      const cv::Point at = cv::Point(FloorDivide(cell.x, kSeamCellsPerBandCell),
                                     FloorDivide(cell.y, kSeamCellsPerBandCell)) -
                           averages.cells.tl();
      averages.sum(at) += cv::Vec3f(layer.picture(row, col)) / kArea;
      averages.share(at) += 1.0f / kArea;
      if (chosen(cell - seam_cells.cells.tl()) == number) {
        averages.chosen_share(at) += 1.0f / kArea;
      }
    }
  }
  return averages;
}

void Smooth(cv::Mat values, double sigma_cells) {
  cv::GaussianBlur(values, values, {}, sigma_cells, sigma_cells, cv::BORDER_CONSTANT);
}

// 0 outside the known cells, 1 from `reach` cells inside them.
cv::Mat1f Taper(const cv::Mat1f& share, double reach) {
  cv::Mat1b known(share > 0.5f), padded;
  cv::copyMakeBorder(known, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::Mat1f distance;
  cv::distanceTransform(padded, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return cv::min(distance(cv::Rect(cv::Point(1, 1), share.size())) / reach, 1.0);
}

Band BandOf(Averages averages, double sigma_cells) {
  Band band;
  band.cells = averages.cells;
  const cv::Mat1f taper = Taper(averages.share, 2.0 * sigma_cells);
  Smooth(averages.sum, sigma_cells);
  Smooth(averages.share, sigma_cells);
  Smooth(averages.chosen_share, sigma_cells);
  band.slow = cv::Mat3f(averages.sum.size());
  for (int row = 0; row < band.slow.rows; ++row) {
    for (int col = 0; col < band.slow.cols; ++col) {
      const float share = std::max(averages.share(row, col), kMinWeight);
      band.slow(row, col) = averages.sum(row, col) / share;
    }
  }
  band.weight = averages.chosen_share.mul(taper);
  return band;
}

cv::Mat3f FactorsOf(const Band& band, const cv::Mat3f& blended, const cv::Mat1f& weight) {
  cv::Mat3f factors(band.slow.size(), cv::Vec3f::all(1.0f));
  for (int row = 0; row < factors.rows; ++row) {
    for (int col = 0; col < factors.cols; ++col) {
      if (weight(row, col) < kMinWeight) continue;
      const cv::Vec3f mean = blended(row, col) / weight(row, col);
      for (int c = 0; c < 3; ++c) {
        const float ratio = (mean[c] + kDarkLevel) / (band.slow(row, col)[c] + kDarkLevel);
        factors(row, col)[c] = std::clamp(ratio, 1.0f / kMaxFactor, kMaxFactor);
      }
    }
  }
  return factors;
}

}  // namespace

std::vector<BlendFactors> BlendLayers(const std::vector<ViewLayer>& layers,
                                      const cv::Mat1s& chosen,
                                      const LatticeRect& seam_cells,
                                      double blend_radius_m) {
  const double sigma_cells =
      std::max(0.3, blend_radius_m / (seam_cells.size_m * kSeamCellsPerBandCell));
  const cv::Rect cells = Coarser(seam_cells.cells, kSeamCellsPerBandCell);
  cv::Mat3f sum(cells.size(), cv::Vec3f::all(0.0f));
  cv::Mat1f weight(cells.size(), 0.0f);
  std::vector<Band> bands;
  for (size_t i = 0; i < layers.size(); ++i) {
    const int number = static_cast<int>(i);
    bands.push_back(BandOf(AveragesOf(layers[i], number, chosen, seam_cells), sigma_cells));
    const Band& band = bands.back();
    const cv::Rect part = band.cells - cells.tl();
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width; ++col) {
        sum(part.y + row, part.x + col) += band.slow(row, col) * band.weight(row, col);
      }
    }
    weight(part) += band.weight;
  }
  std::vector<BlendFactors> factors;
  for (const Band& band : bands) {
    const cv::Rect part = band.cells - cells.tl();
    factors.push_back({band.cells, FactorsOf(band, sum(part), weight(part))});
  }
  return factors;
}

cv::Vec3f FactorAt(const BlendFactors& factors, const cv::Point& seam_cell) {
  const cv::Point at(FloorDivide(seam_cell.x, kSeamCellsPerBandCell),
                     FloorDivide(seam_cell.y, kSeamCellsPerBandCell));
  return factors.factors(at - factors.cells.tl());
}

}  // namespace freelsd
