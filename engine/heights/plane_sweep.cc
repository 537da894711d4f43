#include "engine/heights/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/heights/block_samples.h"

namespace freelsd {
namespace {

// Blocks of about this many samples: small enough for one set of views, wide enough for vectors.
constexpr double kBlockSamples = 9.0;
constexpr int kMaxSamplesPerCell = 10;
// Steps finer than this cost and tell nothing; coarser ones would step over a thing.
constexpr double kMinStepM = 0.125;
constexpr double kMaxStepM = 0.25;
// Spacing of heights: disparity between the outermost views, in samples.
constexpr double kHeightStepPx = 0.5;
// Heights from this far below to this far above the surface are tried.
constexpr double kSearchRangeM = 2.0;
// Spacing of samples on the ground; a map cell is a whole number of them.
constexpr double kSamplingM = 0.2;
// Views per block, those that spread widest.
constexpr int kMaxNumViews = 8;
// Views are not used beyond this horizontal distance, as a share of their height above ground:
// there, things hide the ground behind them.
constexpr double kMaxOffNadirRatio = 1.2;

// Position in a photograph, by height; nothing where it is outside at the proposed height. At other
// heights the photograph's edge repeats: only these heights suffer.
std::optional<LiftedCorner> CornerIn(const GroundPhotograph& photograph,
                                     const Camera& camera,
                                     const Rigid3d& camera_from_world,
                                     const Eigen::Vector3d& place_in_world) {
  std::array<Eigen::Vector2d, 3> at;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d lifted =
        place_in_world + Eigen::Vector3d(0.0, 0.0, (i - 1) * kSearchRangeM);
    const auto pixel = camera.ImageFromCamera(camera_from_world * lifted);
    if (!pixel) return std::nullopt;
    const auto index = static_cast<size_t>(i);
    at[index] = (pixel->array() + 0.5) * photograph.scale - 0.5;
    const Eigen::Vector2d last(photograph.detail.cols - 2, photograph.detail.rows - 2);
    const bool is_inside =
        (at[index].array() >= 1.0).all() && (at[index].array() <= last.array()).all();
    if (i == 1 && !is_inside) return std::nullopt;
  }
  return LiftedCorner{at[1], 0.5 * (at[2] - at[0]), 0.5 * (at[2] + at[0]) - at[1]};
}

}  // namespace

struct PlaneSweep::View {
  size_t index = 0;
  std::shared_ptr<const GroundPhotograph> photograph;
  Camera camera;
  Rigid3d camera_from_world;
};

struct PlaneSweep::LiftedBlock {
  std::vector<LiftedView> views;
  double baseline_ratio = 0.0;
};

SampleGrid SampleGridOf(const Grid& grid) {
  SampleGrid samples{grid};
  const double per_cell = grid.cell_size_m / kSamplingM;
  samples.samples_per_cell =
      std::clamp(static_cast<int>(std::lround(per_cell)), 1, kMaxSamplesPerCell);
  samples.cells_per_block =
      std::max(1, static_cast<int>(std::lround(kBlockSamples / samples.samples_per_cell)));
  return samples;
}

PlaneSweep::PlaneSweep(const ProposalSurface& surface,
                       const SampleGrid& samples,
                       const AdjustedBlock& block,
                       GroundPhotographs& photographs)
    : surface_(surface), samples_(samples), block_(block), photographs_(photographs) {}

std::vector<PlaneSweep::View> PlaneSweep::ViewsAround(const cv::Rect& cells) {
  std::vector<View> views;
  const Eigen::Vector2d middle =
      samples_.grid.CellCenter(cells.y + cells.height / 2, cells.x + cells.width / 2);
  const double reach = cells.width * samples_.grid.cell_size_m;
  for (size_t v = 0; v < block_.views.size(); ++v) {
    const AdjustedView& view = block_.views[v];
    if (!view.is_connected) continue;
    const double farthest = kMaxOffNadirRatio * view.height_above_ground + reach;
    if ((view.world_from_camera.translation.head<2>() - middle).norm() > farthest) continue;
    View around{v, photographs_.Of(v), block_.CameraOf(v), Inverse(view.world_from_camera)};
    if (!around.photograph->detail.empty()) views.push_back(std::move(around));
  }
  return views;
}

PlaneSweep::LiftedBlock PlaneSweep::Lift(const cv::Rect& cells,
                                         const std::vector<View>& views) const {
  LiftedBlock lifted;
  const double cell_m = samples_.grid.cell_size_m;
  std::array<Eigen::Vector3d, 4> corners;
  for (int i = 0; i < 4; ++i) {
    const int row = cells.y + (i / 2) * cells.height, col = cells.x + (i % 2) * cells.width;
    const double height = surface_.At(row - 0.5, col - 0.5);
    if (!std::isfinite(height)) return lifted;
    corners[static_cast<size_t>(i)]
        << samples_.grid.north_west_in_world + cell_m * Eigen::Vector2d(col, -row),
        height;
  }
  std::vector<size_t> seeing;
  std::vector<LiftedView> all;
  for (const View& view : views) {
    const Eigen::Vector2d offset =
        block_.views[view.index].world_from_camera.translation.head<2>() - corners[0].head<2>();
    const double height =
        block_.views[view.index].world_from_camera.translation.z() - corners[0].z();
    if (offset.norm() > kMaxOffNadirRatio * height) continue;
    LiftedView seen{&view.photograph->detail, {}};
    bool is_seen = true;
    for (size_t i = 0; is_seen && i < corners.size(); ++i) {
      const auto corner =
          CornerIn(*view.photograph, view.camera, view.camera_from_world, corners[i]);
      is_seen = corner.has_value();
      if (is_seen) seen.corners[i] = *corner;
    }
    if (!is_seen) continue;
    seeing.push_back(view.index);
    all.push_back(seen);
  }
  const ChosenViews chosen = ChooseViews(block_, seeing, corners[0], kMaxNumViews);
  lifted.views.reserve(chosen.views.size());
  for (const size_t view : chosen.views) {
    const auto at = std::find(seeing.begin(), seeing.end(), view);
    lifted.views.push_back(all[static_cast<size_t>(at - seeing.begin())]);
  }
  lifted.baseline_ratio = chosen.baseline_ratio;
  return lifted;
}

std::vector<double> PlaneSweep::HeightsFor(double baseline_ratio) const {
  const double step = std::clamp(
      kHeightStepPx * samples_.SampleM() / std::max(baseline_ratio, 1e-3), kMinStepM, kMaxStepM);
  const int half = static_cast<int>(std::ceil(kSearchRangeM / step));
  std::vector<double> heights;
  heights.reserve(static_cast<size_t>(2 * half + 1));
  for (int i = -half; i <= half; ++i) heights.push_back(i * kSearchRangeM / half);
  return heights;
}

std::optional<SweptTile> PlaneSweep::Sweep(const cv::Rect& cells) {
  const std::vector<View> views = ViewsAround(cells);
  if (views.size() < 2) return std::nullopt;
  SweptTile tile;
  tile.cells = cells;
  const int side = samples_.cells_per_block;
  const cv::Size num_blocks(cells.width / side, cells.height / side);
  tile.num_views = cv::Mat1f::zeros(num_blocks);
  tile.baseline_ratio = cv::Mat1f::zeros(num_blocks);
  std::vector<LiftedBlock> blocks;
  blocks.reserve(static_cast<size_t>(num_blocks.area()));
  double widest = 0.0;
  for (int row = 0; row < num_blocks.height; ++row) {
    for (int col = 0; col < num_blocks.width; ++col) {
      blocks.push_back(Lift({cells.x + col * side, cells.y + row * side, side, side}, views));
      tile.num_views(row, col) = static_cast<float>(blocks.back().views.size());
      tile.baseline_ratio(row, col) = static_cast<float>(blocks.back().baseline_ratio);
      if (blocks.back().views.size() >= 2) widest = std::max(widest, blocks.back().baseline_ratio);
    }
  }
  if (widest <= 0.0) return std::nullopt;
  tile.heights = HeightsFor(widest);
  const auto num_heights = tile.heights.size();
  const int per_block = samples_.SamplesPerBlock();
  const SamplePattern pattern(per_block);
  const cv::Size size(num_blocks.width * per_block, num_blocks.height * per_block);
  tile.variance.resize(num_heights);
  tile.power.resize(num_heights);
  cv::parallel_for_({0, static_cast<int>(num_heights)}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      const auto h = static_cast<size_t>(i);
      tile.variance[h] = cv::Mat1f::zeros(size);
      tile.power[h] = cv::Mat1f::zeros(size);
      for (size_t b = 0; b < blocks.size(); ++b) {
        if (blocks[b].views.size() < 2) continue;
        const int row = static_cast<int>(b) / num_blocks.width * per_block;
        const int col = static_cast<int>(b) % num_blocks.width * per_block;
        const cv::Rect at(col, row, per_block, per_block);
        CompareViews(blocks[b].views,
                     tile.heights[h] / kSearchRangeM,
                     pattern,
                     {tile.variance[h](at), tile.power[h](at)});
      }
    }
  });
  return tile;
}

}  // namespace freelsd
