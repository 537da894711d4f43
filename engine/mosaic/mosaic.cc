#include "engine/mosaic/mosaic.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "engine/mosaic/balance.h"
#include "engine/mosaic/pyramid.h"
#include "engine/mosaic/seams.h"
#include "engine/mosaic/tile_painter.h"

namespace freelsd {
namespace {

// A view with up to this much less detail than its neighbours (natural logarithm) is as good as
// they.
constexpr double kUsualLackOfDetail = 0.1;

// Loads every image that has candidates once, as many at once as there are threads. Returns the
// views whose image cannot be used.
std::vector<size_t> AddPictures(const PictureGround& ground,
                                const AdjustedBlock& block,
                                const ImageSource& images,
                                double seam_cell_size_m,
                                std::vector<ViewLayer>& layers) {
  cv::parallel_for_({0, static_cast<int>(layers.size())}, [&](const cv::Range& range) {
    for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
      ViewLayer& layer = layers[i];
      const cv::Mat image = images(block.views[layer.view].frame_id);
      if (!IsUsable(image, block.camera)) continue;
      AddPicture(image, GroundView(ground, block, layer.view), seam_cell_size_m, layer);
    }
  });
  std::vector<size_t> missing;
  for (const ViewLayer& layer : layers) {
    if (layer.picture.empty()) missing.push_back(layer.view);
  }
  return missing;
}

// Layers with pictures. Views without image leave their place to others, so the choice is repeated
// without them.
std::vector<ViewLayer> LoadLayers(const PictureGround& ground,
                                  const AdjustedBlock& block,
                                  const ImageSource& images,
                                  const LatticeRect& seam_cells,
                                  const MosaicOptions& options,
                                  MosaicReport& report) {
  const int margin_cells =
      static_cast<int>(std::ceil(2.5 * options.blend_radius_m / seam_cells.size_m));
  std::vector<bool> is_wanted(block.views.size(), true);
  while (true) {
    std::vector<ViewLayer> layers = WithCandidates(
        LayersOf(ground, block, seam_cells, is_wanted, options), seam_cells, margin_cells, options);
    const std::vector<size_t> missing =
        AddPictures(ground, block, images, seam_cells.size_m, layers);
    if (missing.empty()) return layers;
    report.num_missing_images += static_cast<int>(missing.size());
    for (const size_t view : missing) is_wanted[view] = false;
  }
}

std::vector<Tone> TonesOf(const std::vector<ViewLayer>& layers,
                          const AdjustedBlock& block,
                          const MosaicOptions& options) {
  std::vector<Eigen::Vector2d> cameras;
  cameras.reserve(layers.size());
  for (const ViewLayer& layer : layers) {
    cameras.push_back(block.views[layer.view].world_from_camera.translation.head<2>());
  }
  return Balance(cameras, Compare(layers), options.gain_sd);
}

// Applies the tones to the layers' pictures.
void ApplyTones(const std::vector<Tone>& tones,
                double seam_cell_size_m,
                const MosaicOptions& options,
                std::vector<ViewLayer>& layers) {
  for (size_t i = 0; i < layers.size(); ++i) {
    ViewLayer& layer = layers[i];
    const LatticeRect rect{seam_cell_size_m, layer.cells};
    for (int row = 0; row < layer.picture.rows; ++row) {
      for (int col = 0; col < layer.picture.cols; ++col) {
        const cv::Vec3f factor = tones[i].FactorAt(rect.CellCenter(row, col));
        cv::Vec3b& color = layer.picture(row, col);
        for (int c = 0; c < 3; ++c) color[c] = cv::saturate_cast<uint8_t>(color[c] * factor[c]);
      }
    }
    const double lack = std::max(0.0, tones[i].log_gain[3] - kUsualLackOfDetail);
    layer.blur_cost = static_cast<int>(std::lround(options.blur_cost * lack));
  }
}

// Steps of brightness at seams: as photographed, with tones, and blended.
void MeasureSteps(const std::vector<ViewLayer>& layers,
                  const std::vector<Tone>& tones,
                  const MosaicDesign& design,
                  MosaicReport& report) {
  const auto color_of = [&](size_t layer, const cv::Point& cell) {
    return cv::Vec3d(layers[layer].picture(cell - layers[layer].cells.tl()));
  };
  const auto tone_of = [&](size_t layer, const cv::Point& cell) {
    const LatticeRect rect{design.seam_cells.size_m, {cell, cv::Size(1, 1)}};
    return cv::Vec3d(tones[layer].FactorAt(rect.CellCenter(0, 0)));
  };
  const auto step_of = [&](const auto& color) {
    return MeanStep(layers, design.chosen, design.seam_cells, color);
  };
  report.step_photographed = step_of([&](size_t layer, const cv::Point& cell) {
    const cv::Vec3d color = color_of(layer, cell), tone = tone_of(layer, cell);
    return cv::Vec3d(color[0] / tone[0], color[1] / tone[1], color[2] / tone[2]);
  });
  report.step_with_gains = step_of(color_of);
  report.step_blended = step_of([&](size_t layer, const cv::Point& cell) {
    return color_of(layer, cell).mul(cv::Vec3d(FactorAt(design.factors[layer], cell)));
  });
}

// Multiplies the factors by the tones.
void AddTones(const std::vector<Tone>& tones,
              double band_cell_size_m,
              std::vector<BlendFactors>& factors) {
  for (size_t i = 0; i < factors.size(); ++i) {
    const LatticeRect rect{band_cell_size_m, factors[i].cells};
    for (int row = 0; row < rect.cells.height; ++row) {
      for (int col = 0; col < rect.cells.width; ++col) {
        cv::Vec3f& factor = factors[i].factors(row, col);
        factor = factor.mul(tones[i].FactorAt(rect.CellCenter(row, col)));
      }
    }
  }
}

Grid GridOf(const LatticeRect& rect) {
  Grid grid;
  grid.north_west_in_world = Eigen::Vector2d(rect.cells.x, -rect.cells.y) * rect.size_m;
  grid.cell_size_m = rect.size_m;
  grid.num_rows = rect.cells.height;
  grid.num_cols = rect.cells.width;
  return grid;
}

MosaicDesign DesignMosaic(const PictureGround& ground,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const MosaicOptions& options,
                          MosaicReport& report) {
  MosaicDesign design;
  design.lattice = report.lattice;
  design.pixels_per_seam_cell = PixelsPerSeamCell(design.lattice, options);
  const double pixel_size_m = design.lattice.pixel_size_m;
  design.seam_cells = {pixel_size_m * design.pixels_per_seam_cell,
                       Coarser(PixelsOf(ground.grid(), pixel_size_m), design.pixels_per_seam_cell)};
  std::vector<ViewLayer> layers =
      LoadLayers(ground, block, images, design.seam_cells, options, report);
  const std::vector<Tone> tones = TonesOf(layers, block, options);
  ApplyTones(tones, design.seam_cells.size_m, options, layers);
  design.chosen = ChooseLayers(layers, design.seam_cells, options);
  design.factors = BlendLayers(layers, design.chosen, design.seam_cells, options.blend_radius_m);
  MeasureSteps(layers, tones, design, report);
  AddTones(tones, design.seam_cells.size_m * kSeamCellsPerBandCell, design.factors);
  for (size_t i = 0; i < layers.size(); ++i) {
    design.views.push_back(layers[i].view);
    report.gains[layers[i].view] = tones[i].Gain();
  }
  return design;
}

void Describe(const MosaicDesign& design, MosaicReport& report) {
  report.seam_grid = GridOf(design.seam_cells);
  report.view = cv::Mat1s(design.chosen.size(), int16_t{-1});
  std::transform(
      design.chosen.begin(), design.chosen.end(), report.view.begin(), [&](int16_t layer) {
        return layer < 0 ? int16_t{-1}
                         : static_cast<int16_t>(design.views[static_cast<size_t>(layer)]);
      });
}

}  // namespace

MosaicReport MakeMosaic(const ElevationMap& map,
                        const AdjustedBlock& block,
                        const ImageSource& images,
                        const MosaicOptions& options,
                        const std::function<void(const MosaicTile&)>& keep) {
  MosaicReport report;
  report.lattice = PlanMosaic(map, block, options);
  report.gains.assign(block.views.size(), cv::Vec3d::all(1.0));
  if (report.lattice.num_levels == 0) return report;
  const PictureGround ground(map, options);
  const MosaicDesign design = DesignMosaic(ground, block, images, options, report);
  Describe(design, report);
  TilePainter painter(design, ground, block, images, options.max_cache_mb);
  report.num_tiles = BuildPyramid(
      report.lattice, [&](int row, int col) { return painter.Paint(row, col); }, keep);
  return report;
}

}  // namespace freelsd
