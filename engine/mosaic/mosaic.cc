#include "engine/mosaic/mosaic.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/mosaic/balance.h"
#include "engine/mosaic/pyramid.h"
#include "engine/mosaic/seams.h"
#include "engine/mosaic/tile_painter.h"

namespace freelsd {
namespace {

// A view with up to this much less detail than its neighbours (natural logarithm) is as good as
// they.
constexpr double kUsualLackOfDetail = 0.1;

// Loads every image that has candidates once. Returns the views whose image cannot be used.
std::vector<size_t> AddPictures(const PictureGround& ground,
                                const AdjustedBlock& block,
                                const ImageSource& images,
                                double seam_cell_size_m,
                                std::vector<ViewLayer>& layers) {
  std::vector<size_t> missing;
  for (ViewLayer& layer : layers) {
    const cv::Mat image = images(block.views[layer.view].frame_id);
    if (!IsUsable(image, block.camera)) {
      missing.push_back(layer.view);
      continue;
    }
    AddPicture(image, GroundView(ground, block, layer.view), seam_cell_size_m, layer);
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

// Applies the gains to the layers' pictures.
std::vector<cv::Vec3d> Balance(const MosaicOptions& options, std::vector<ViewLayer>& layers) {
  const std::vector<cv::Vec4d> log_gains =
      LogGains(layers.size(), Compare(layers), options.gain_sd);
  std::vector<cv::Vec3d> gains;
  for (size_t i = 0; i < layers.size(); ++i) {
    const cv::Vec4d& log_gain = log_gains[i];
    gains.emplace_back(std::exp(log_gain[0]), std::exp(log_gain[1]), std::exp(log_gain[2]));
    cv::multiply(layers[i].picture, cv::Scalar(gains.back()), layers[i].picture);
    const double lack = std::max(0.0, log_gain[3] - kUsualLackOfDetail);
    layers[i].blur_cost = static_cast<int>(std::lround(options.blur_cost * lack));
  }
  return gains;
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
  design.gains = Balance(options, layers);
  design.chosen = ChooseLayers(layers, design.seam_cells, options);
  design.blending = BlendLayers(layers, design.chosen, design.seam_cells, options.blend_radius_m);
  for (const ViewLayer& layer : layers) design.views.push_back(layer.view);
  const std::vector<cv::Vec3d> ones(layers.size(), cv::Vec3d::all(1.0));
  report.step_photographed = MeanStep(layers, design.gains, design.chosen, design.seam_cells);
  report.step_with_gains = MeanStep(layers, ones, design.chosen, design.seam_cells);
  report.step_blended =
      MeanStep(Blended(std::move(layers), design.blending), ones, design.chosen, design.seam_cells);
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
  for (size_t i = 0; i < design.views.size(); ++i) report.gains[design.views[i]] = design.gains[i];
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
  const PictureGround ground(map, options.max_hole_m);
  const MosaicDesign design = DesignMosaic(ground, block, images, options, report);
  Describe(design, report);
  TilePainter painter(design, ground, block, images, options.max_cache_mb);
  report.num_tiles = BuildPyramid(
      report.lattice, [&](int row, int col) { return painter.Paint(row, col); }, keep);
  return report;
}

}  // namespace freelsd
