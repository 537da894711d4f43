#include "engine/cover/kind_fusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/cover/guided_filter.h"

namespace freelsd {
namespace {

// A block of this side, in cells, is tested against a view at once: most views see little of a map.
constexpr int kBlockSize = 16;
// A single view calls a cell grass from this probability on (the paper's binary fine mask).
constexpr double kBinaryProbability = 0.5;
// Points per image edge at which the field of view is measured, because distortion bends edges.
constexpr int kNumEdgeSamples = 8;

struct Votes {
  float log_odds = 0.0f;
  uint16_t num_looks = 0;
  uint16_t num_votes = 0;
  bool has_grass = false;
  std::array<float, kNumGroundKinds> others{};
};

// Rounds half away from zero like std::lround, which compilers do not inline.
int Rounded(double value) {
  const int whole = static_cast<int>(value);
  const double rest = value - whole;
  return whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};

// Cells of a block that the map sees.
struct SeenCell {
  int row;
  int col;
  Eigen::Vector3d place_in_world;
};

std::vector<SeenCell> SeenCells(const ElevationMap& map, const cv::Rect& block) {
  std::vector<SeenCell> cells;
  cells.reserve(static_cast<size_t>(block.area()));
  for (int row = block.y; row < block.y + block.height; ++row) {
    for (int col = block.x; col < block.x + block.width; ++col) {
      if (!map.IsSeen(row, col)) continue;
      const Eigen::Vector2d center = map.grid.CellCenter(row, col);
      cells.push_back({row, col, {center.x(), center.y(), map.elevation(row, col)}});
    }
  }
  return cells;
}

Sphere SphereAround(const ElevationMap& map,
                    const cv::Rect& block,
                    const std::vector<SeenCell>& cells) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const SeenCell& cell : cells) {
    lowest = std::min(lowest, cell.place_in_world.z());
    highest = std::max(highest, cell.place_in_world.z());
  }
  Eigen::Vector3d near, far;
  near << map.grid.CellCenter(block.y, block.x), lowest;
  far << map.grid.CellCenter(block.y + block.height - 1, block.x + block.width - 1), highest;
  return {0.5 * (near + far), 0.5 * (far - near).norm()};
}

// Largest angle between the optical axis and a ray through the border of the image.
double HalfFieldOfView(const Camera& camera) {
  double half_angle = 0.0;
  for (int i = 0; i <= kNumEdgeSamples; ++i) {
    const double x = camera.width_px * i / static_cast<double>(kNumEdgeSamples) - 0.5;
    const double y = camera.height_px * i / static_cast<double>(kNumEdgeSamples) - 0.5;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, -0.5),
                                         Eigen::Vector2d(x, camera.height_px - 0.5),
                                         Eigen::Vector2d(-0.5, y),
                                         Eigen::Vector2d(camera.width_px - 0.5, y)}) {
      half_angle = std::max(half_angle, std::acos(camera.RayFromImage(pixel).z()));
    }
  }
  return half_angle;
}

bool MaySee(const Rigid3d& camera_from_world, double half_angle, const Sphere& sphere) {
  const Eigen::Vector3d center = camera_from_world * sphere.center;
  const double distance = center.norm();
  if (distance <= sphere.radius) return true;
  const double angle = std::acos(std::clamp(center.z() / distance, -1.0, 1.0));
  return angle <= half_angle + std::asin(sphere.radius / distance);
}

class Voter {
 public:
  Voter(const KindView& view, double min_probability, double max_probability)
      : view_(view),
        camera_from_world_(Inverse(view.world_from_camera)),
        rotation_(camera_from_world_.rotation.toRotationMatrix()),
        half_angle_(HalfFieldOfView(view.camera)) {
    for (int value = 0; value < 256; ++value) {
      const double probability = std::clamp((value - 1) / 254.0, min_probability, max_probability);
      log_odds_[value] = static_cast<float>(std::log(probability / (1.0 - probability)));
    }
  }

  bool MaySee(const Sphere& sphere) const {
    return freelsd::MaySee(camera_from_world_, half_angle_, sphere);
  }

  // Counts a view of the place, and its vote if the view classified the place.
  void Vote(const Eigen::Vector3d& place_in_world, Votes& votes) const {
    const std::optional<Eigen::Vector2d> pixel =
        view_.camera.ImageFromCamera(rotation_ * place_in_world + camera_from_world_.translation);
    if (!pixel || !view_.camera.IsInside(*pixel)) return;
    const KindPicture& picture = view_.picture;
    const Eigen::Vector2d in_picture = (pixel->array() + 0.5) / picture.image_px_per_px - 0.5;
    const int x = Rounded(in_picture.x()), y = Rounded(in_picture.y());
    if (x < 0 || y < 0 || x >= picture.grass.cols || y >= picture.grass.rows) return;
    ++votes.num_looks;
    const uint8_t value = picture.grass(y, x);
    if (value == 0) return;
    ++votes.num_votes;
    votes.log_odds += log_odds_[value];
    votes.has_grass = votes.has_grass || (value - 1) / 254.0 >= kBinaryProbability;
    if (picture.other.empty()) return;
    const LikelyKind other = LikelyKind::Unpack(picture.other(y, x));
    votes.others[static_cast<size_t>(other.kind)] += other.probability;
  }

 private:
  const KindView& view_;
  Rigid3d camera_from_world_;
  Eigen::Matrix3d rotation_;
  double half_angle_;
  float log_odds_[256];
};

// Mean log-odds of grass over the views; NaN where too few of them told the cell.
float MeanLogOdds(const Votes& votes, const CoverOptions& options) {
  if (votes.num_votes == 0 || votes.num_votes < options.min_vote_ratio * votes.num_looks) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  if (options.grass_fusion == GrassFusion::kPaperOr) {
    return votes.has_grass ? std::numeric_limits<float>::infinity()
                           : -std::numeric_limits<float>::infinity();
  }
  return votes.log_odds / static_cast<float>(votes.num_votes);
}

uint8_t FusedOther(const Votes& votes) {
  const auto likeliest = std::max_element(votes.others.begin(), votes.others.end());
  if (!(*likeliest > 0.0f)) return 0;
  return LikelyKind{static_cast<GroundKind>(likeliest - votes.others.begin()),
                    *likeliest / static_cast<float>(votes.num_votes)}
      .Packed();
}

// Calls take(row, col, votes) for every cell that the map sees.
template <typename Take>
void CountBlock(const ElevationMap& map,
                const cv::Rect& block,
                const std::vector<Voter>& voters,
                Take take) {
  const std::vector<SeenCell> cells = SeenCells(map, block);
  if (cells.empty()) return;
  const Sphere sphere = SphereAround(map, block, cells);
  std::vector<Votes> votes(cells.size());
  for (const Voter& voter : voters) {
    if (!voter.MaySee(sphere)) continue;
    for (size_t i = 0; i < cells.size(); ++i) voter.Vote(cells[i].place_in_world, votes[i]);
  }
  for (size_t i = 0; i < cells.size(); ++i) take(cells[i].row, cells[i].col, votes[i]);
}

template <typename Take>
void CountBlocks(const ElevationMap& map,
                 const std::vector<KindView>& kind_views,
                 double min_probability,
                 double max_probability,
                 Take take) {
  std::vector<Voter> voters;
  for (const KindView& view : kind_views) {
    if (!view.picture.grass.empty()) voters.emplace_back(view, min_probability, max_probability);
  }
  const cv::Rect whole({}, map.elevation.size());
  for (int row = 0; row < whole.height; row += kBlockSize) {
    for (int col = 0; col < whole.width; col += kBlockSize) {
      CountBlock(map, cv::Rect(col, row, kBlockSize, kBlockSize) & whole, voters, take);
    }
  }
}

}  // namespace

std::pair<cv::Mat1f, cv::Mat1b> FuseKinds(const ElevationMap& map,
                                          const std::vector<KindView>& kind_views,
                                          const CoverOptions& options,
                                          const Orthophoto& photo) {
  cv::Mat1f log_odds(map.elevation.size(), std::numeric_limits<float>::quiet_NaN());
  cv::Mat1f num_independent = cv::Mat1f::zeros(map.elevation.size());
  cv::Mat1b other = cv::Mat1b::zeros(map.elevation.size());
  const auto most = static_cast<float>(options.max_num_independent_views);
  CountBlocks(map,
              kind_views,
              options.min_observation_probability,
              options.max_observation_probability,
              [&](int row, int col, const Votes& votes) {
                log_odds(row, col) = MeanLogOdds(votes, options);
                num_independent(row, col) = std::min(static_cast<float>(votes.num_votes), most);
                other(row, col) = FusedOther(votes);
              });
  // What grows is the same over more than a cell, and the network's noise is not.
  cv::Mat1f grass = SmoothedByPhoto(
      log_odds, photo, map.grid.cell_size_m, options.kind_smoothing_m, options.min_kind_contrast);
  std::transform(grass.begin(),
                 grass.end(),
                 num_independent.begin(),
                 grass.begin(),
                 [](float mean, float num) { return 1.0f / (1.0f + std::exp(-num * mean)); });
  return {grass, other};
}

}  // namespace freelsd
