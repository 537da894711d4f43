#include "engine/hazard/wheel_tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr int kNumDirections = 18;
// What is green about a place is compared with this much around it.
constexpr double kSurroundingsM = 5.0;
// Distance between the two ruts of a vehicle, tried in steps of a rut's half width.
constexpr std::array<double, 4> kGaugesM{1.5, 1.75, 2.0, 2.25};
// Beside the ruts the crop stands again: that far outside them.
constexpr double kBesideM = 0.85;
// A rut is narrower than twice this, and a line is looked at in steps of half a metre.
constexpr double kMaxRutHalfWidthM = 0.75;
constexpr double kSampleStepM = 0.5;
// Crops are looked for among green plants: less green than this all around is soil, straw or road.
constexpr float kMinGreen = 0.05f;
// Places of a track are gathered in squares of this side, and belong together up to that gap.
constexpr double kSquareM = 0.5;
constexpr int kMaxGapSquares = 4;
constexpr double kMaxBendRad = 0.3;
// A track may bend by this much from the line through it, as a deviation.
constexpr double kMaxWaveM = 1.2;
constexpr double kParallelRad = 0.17;
// Neighbours lie beside each other for at least this share of the shorter one.
constexpr double kMinOverlapRatio = 0.3;

// How much less green each cell is than what surrounds it: excess green (Woebbecke et al. 1995) as
// a share of the brightness, so that shade does not count. 0 where unseen.
cv::Mat1f LackOfGreen(const Orthophoto& photo) {
  cv::Mat1f green(photo.image.size(), 0.0f), seen(photo.image.size(), 0.0f);
  for (int row = 0; row < green.rows; ++row) {
    for (int col = 0; col < green.cols; ++col) {
      if (!photo.seen(row, col)) continue;
      const cv::Vec3b& bgr = photo.image(row, col);
      const float sum = static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + 1.0f;
      green(row, col) = (3.0f * bgr[1] - sum) / sum;
      seen(row, col) = 1.0f;
    }
  }
  const int size = 2 * static_cast<int>(0.5 * kSurroundingsM / photo.grid.cell_size_m) + 1;
  cv::Mat1f mean, count;
  cv::boxFilter(green, mean, CV_32F, {size, size});
  cv::boxFilter(seen, count, CV_32F, {size, size});
  cv::Mat1f lack(green.size(), 0.0f);
  for (int row = 0; row < green.rows; ++row) {
    for (int col = 0; col < green.cols; ++col) {
      if (seen(row, col) == 0.0f) continue;
      const float around = mean(row, col) / count(row, col);
      if (around >= kMinGreen) lack(row, col) = around - green(row, col);
    }
  }
  return lack;
}

// A place midway between two ruts, in cells of the photograph.
struct TrackPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double direction = 0.0;  // radians from a row's own, in [0, pi)
  double contrast = 0.0;
};

// Looks for a pair of ruts at one cell in every direction. Means are taken over lines of cells,
// whose offsets are the same everywhere.
class RutFilter {
 public:
  RutFilter(const cv::Mat1f& lack, double cell_size_m, const HazardOptions& options)
      : cell_size_(cell_size_m), min_contrast_(options.min_rut_contrast) {
    const double reach_m =
        0.5 * options.rut_filter_length_m + kGaugesM.back() + kBesideM + kMaxRutHalfWidthM;
    margin_ = static_cast<int>(std::ceil(reach_m / cell_size_m)) + 1;
    // Outside there is nothing to lack.
    cv::copyMakeBorder(
        lack, lack_, margin_, margin_, margin_, margin_, cv::BORDER_CONSTANT, cv::Scalar(0.0));
    const int num_steps = static_cast<int>(0.5 * options.rut_filter_length_m / kSampleStepM);
    for (int i = 0; i < kNumDirections; ++i) {
      const double direction = kPi * i / kNumDirections;
      Direction& made = directions_[i];
      made.along = Eigen::Vector2d(std::cos(direction), std::sin(direction));
      made.across = Eigen::Vector2d(-made.along.y(), made.along.x());
      for (int step = -num_steps; step <= num_steps; ++step) {
        made.line.push_back(OffsetOf(made.along * (step * kSampleStepM / cell_size_)));
      }
      made.before = OffsetOf(-made.across * (kBesideM / cell_size_));
      for (const double gauge_m : kGaugesM) {
        const Eigen::Vector2d step = made.across * (gauge_m / cell_size_);
        made.gauges.push_back({OffsetOf(step),
                               OffsetOf(0.5 * step),
                               OffsetOf(step + made.across * (kBesideM / cell_size_)),
                               step});
      }
    }
    for (const auto& [right, down] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
      const double length = std::hypot(right, down) * cell_size_;
      sides_.push_back(OffsetOf(Eigen::Vector2d(right, down) * (kMaxRutHalfWidthM / length)));
    }
  }

  // With the direction that tells most; nothing where there is no pair of ruts.
  std::optional<TrackPlace> At(int row, int col) const {
    const float* cell = lack_[row + margin_] + col + margin_;
    if (*cell < min_contrast_ || !StandsOut(cell)) return std::nullopt;
    std::optional<TrackPlace> best;
    for (int i = 0; i < kNumDirections; ++i) {
      const auto place = Along(cell, Eigen::Vector2d(col, row), i);
      if (place && (!best || place->contrast > best->contrast)) best = place;
    }
    return best;
  }

 private:
  struct Gauge {
    std::ptrdiff_t other_rut = 0;
    std::ptrdiff_t between = 0;
    std::ptrdiff_t behind = 0;
    Eigen::Vector2d step = Eigen::Vector2d::Zero();
  };
  struct Direction {
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
    Eigen::Vector2d across = Eigen::Vector2d::Zero();
    std::vector<std::ptrdiff_t> line;
    std::ptrdiff_t before = 0;
    std::vector<Gauge> gauges;
  };

  std::ptrdiff_t OffsetOf(const Eigen::Vector2d& step) const {
    return std::lround(step.y()) * static_cast<std::ptrdiff_t>(lack_.step1()) +
           std::lround(step.x());
  }

  // From both sides, in some direction: most cells do not.
  bool StandsOut(const float* cell) const {
    return std::any_of(sides_.begin(), sides_.end(), [&](std::ptrdiff_t side) {
      return *cell - std::max(cell[side], cell[-side]) >= 0.3 * min_contrast_;
    });
  }

  std::optional<TrackPlace> Along(const float* rut, const Eigen::Vector2d& place, int index) const {
    const Direction& direction = directions_[index];
    const double own = MeanLack(rut, direction);
    if (own < min_contrast_) return std::nullopt;
    const double before = MeanLack(rut + direction.before, direction);
    if (own - before < min_contrast_) return std::nullopt;
    std::optional<TrackPlace> best;
    for (const Gauge& gauge : direction.gauges) {
      const double ruts = std::min(own, MeanLack(rut + gauge.other_rut, direction));
      if (ruts < min_contrast_) continue;
      const double between = MeanLack(rut + gauge.between, direction);
      const double behind = MeanLack(rut + gauge.behind, direction);
      const double contrast = ruts - std::max({before, between, behind});
      if (contrast < min_contrast_ || (best && contrast <= best->contrast)) continue;
      best = TrackPlace{place + 0.5 * gauge.step, kPi * index / kNumDirections, contrast};
    }
    return best;
  }

  static double MeanLack(const float* middle, const Direction& direction) {
    float sum = 0.0f;
    for (const std::ptrdiff_t offset : direction.line) sum += middle[offset];
    return sum / static_cast<double>(direction.line.size());
  }

  cv::Mat1f lack_;
  int margin_ = 0;
  double cell_size_;
  double min_contrast_;
  std::array<Direction, kNumDirections> directions_;
  std::vector<std::ptrdiff_t> sides_;
};

// Of places in one square the clearest, by row and column of the square.
using Squares = std::map<std::pair<int, int>, TrackPlace>;

Squares GatherPlaces(const cv::Mat1f& lack, double cell_size_m, const HazardOptions& options) {
  const RutFilter filter(lack, cell_size_m, options);
  Squares squares;
  for (int row = 0; row < lack.rows; ++row) {
    for (int col = 0; col < lack.cols; ++col) {
      const std::optional<TrackPlace> found = filter.At(row, col);
      if (!found) continue;
      const Eigen::Vector2d square = found->place * cell_size_m / kSquareM;
      const std::pair<int, int> key(int(std::floor(square.y())), int(std::floor(square.x())));
      const auto [it, is_new] = squares.try_emplace(key, *found);
      if (!is_new && found->contrast > it->second.contrast) it->second = *found;
    }
  }
  return squares;
}

double AngleBetween(double a, double b) {
  const double turn = std::abs(a - b);
  return std::min(turn, kPi - turn);
}

// Which places belong to one track: the roots of a forest over their indices.
class Chains {
 public:
  explicit Chains(size_t num_places) : parents_(num_places) {
    std::iota(parents_.begin(), parents_.end(), size_t{0});
  }
  size_t Root(size_t index) {
    while (parents_[index] != index) index = parents_[index] = parents_[parents_[index]];
    return index;
  }
  void Join(size_t a, size_t b) {
    const size_t root_a = Root(a), root_b = Root(b);
    parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<size_t> parents_;
};

std::vector<std::vector<TrackPlace>> ChainsOf(const Squares& squares) {
  std::vector<TrackPlace> places;
  std::map<std::pair<int, int>, size_t> index_of;
  for (const auto& [key, place] : squares) {
    index_of[key] = places.size();
    places.push_back(place);
  }
  Chains chains(places.size());
  for (const auto& [key, index] : index_of) {
    // Those after it, row by row: the ones before it have looked at it.
    for (int dr = 0; dr <= kMaxGapSquares; ++dr) {
      for (int dc = dr == 0 ? 1 : -kMaxGapSquares; dc <= kMaxGapSquares; ++dc) {
        const auto other = index_of.find({key.first + dr, key.second + dc});
        if (other == index_of.end()) continue;
        const double bend = AngleBetween(places[index].direction, places[other->second].direction);
        if (bend <= kMaxBendRad) chains.Join(index, other->second);
      }
    }
  }
  std::map<size_t, std::vector<TrackPlace>> by_root;
  for (size_t i = 0; i < places.size(); ++i) by_root[chains.Root(i)].push_back(places[i]);
  std::vector<std::vector<TrackPlace>> gathered;
  for (auto& [root, chain] : by_root) gathered.push_back(std::move(chain));
  return gathered;
}

// The line through the places of one track; nothing if it is short or no line.
std::optional<WheelTrack> TrackThrough(const std::vector<TrackPlace>& chain,
                                       const Grid& grid,
                                       const HazardOptions& options) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const TrackPlace& place : chain) mean += place.place / static_cast<double>(chain.size());
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const TrackPlace& place : chain) {
    moments += (place.place - mean) * (place.place - mean).transpose();
  }
  const double turn = 0.5 * std::atan2(2.0 * moments(0, 1), moments(0, 0) - moments(1, 1));
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
  double first = 0.0, last = 0.0;
  for (const TrackPlace& place : chain) {
    first = std::min(first, (place.place - mean).dot(along));
    last = std::max(last, (place.place - mean).dot(along));
  }
  const double cell = grid.cell_size_m;
  const double wave_m =
      cell * std::sqrt(across.dot(moments * across) / static_cast<double>(chain.size()));
  if ((last - first) * cell < options.min_track_length_m || wave_m > kMaxWaveM) return std::nullopt;
  const auto in_world = [&](const Eigen::Vector2d& place) -> Eigen::Vector2d {
    return grid.north_west_in_world + cell * Eigen::Vector2d(place.x() + 0.5, -(place.y() + 0.5));
  };
  return WheelTrack{in_world(mean + first * along), in_world(mean + last * along)};
}

// A track in the frame of another one: across to the left of it, from where to where along it.
struct Beside {
  double across = 0.0;
  double first = 0.0;
  double last = 0.0;
};

Beside BesideOf(const WheelTrack& track, const WheelTrack& other) {
  const Eigen::Vector2d along = (track.end - track.start).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double start = (other.start - track.start).dot(along);
  const double end = (other.end - track.start).dot(along);
  const Eigen::Vector2d middle = 0.5 * (other.start + other.end);
  return {(middle - track.start).dot(across), std::min(start, end), std::max(start, end)};
}

// Nothing for one that is not beside it, or not parallel.
std::optional<Beside> NeighbourOf(const WheelTrack& track,
                                  const WheelTrack& other,
                                  const HazardOptions& options) {
  const Eigen::Vector2d own = track.end - track.start, its = other.end - other.start;
  const double sine = std::abs(own.x() * its.y() - own.y() * its.x()) / (own.norm() * its.norm());
  if (sine > std::sin(kParallelRad)) return std::nullopt;
  const Beside beside = BesideOf(track, other);
  const double distance = std::abs(beside.across);
  if (distance < options.min_working_width_m || distance > options.max_working_width_m) {
    return std::nullopt;
  }
  const double overlap = std::min(beside.last, own.norm()) - std::max(beside.first, 0.0);
  if (overlap < kMinOverlapRatio * std::min(own.norm(), its.norm())) return std::nullopt;
  return beside;
}

struct Neighbour {
  size_t index = 0;
  Beside beside;
};
// To the right and to the left.
using Neighbours = std::array<std::optional<Neighbour>, 2>;

Neighbours NearestOnEitherSide(const WheelTrack& track,
                               const std::vector<WheelTrack>& tracks,
                               const HazardOptions& options) {
  Neighbours nearest;
  for (size_t i = 0; i < tracks.size(); ++i) {
    const std::optional<Beside> beside = NeighbourOf(track, tracks[i], options);
    if (!beside) continue;
    std::optional<Neighbour>& side = nearest[beside->across > 0.0 ? 1 : 0];
    if (!side || std::abs(beside->across) < std::abs(side->beside.across)) side = {i, *beside};
  }
  return nearest;
}

// The last pass may lie nearer to the round about the field than a working width; the widest gap
// tells more.
double WidestGap(const Neighbours& neighbours) {
  double widest = 0.0;
  for (const std::optional<Neighbour>& side : neighbours) {
    if (side) widest = std::max(widest, std::abs(side->beside.across));
  }
  return widest;
}

// The rectangle along a track, from where to where, and how far to its right and left.
struct Strip {
  double first = 0.0;
  double last = 0.0;
  double right = 0.0;
  double left = 0.0;
};

void Fill(const WheelTrack& track, const Strip& strip, const Grid& grid, cv::Mat1b& mask) {
  const Eigen::Vector2d along = (track.end - track.start).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(strip.first, strip.right),
                                        Eigen::Vector2d(strip.last, strip.right),
                                        Eigen::Vector2d(strip.last, strip.left),
                                        Eigen::Vector2d(strip.first, strip.left)}) {
    const Eigen::Vector2d offset =
        track.start + corner.x() * along + corner.y() * across - grid.north_west_in_world;
    corners.emplace_back(static_cast<int>(std::floor(offset.x() / grid.cell_size_m)),
                         static_cast<int>(std::floor(-offset.y() / grid.cell_size_m)));
  }
  cv::fillConvexPoly(mask, corners, cv::Scalar(255));
}

}  // namespace

std::vector<WheelTrack> FindWheelTracks(const Orthophoto& photo, const HazardOptions& options) {
  std::vector<WheelTrack> tracks;
  if (photo.image.empty()) return tracks;
  const cv::Mat1f lack = LackOfGreen(photo);
  for (const auto& chain : ChainsOf(GatherPlaces(lack, photo.grid.cell_size_m, options))) {
    const auto track = TrackThrough(chain, photo.grid, options);
    if (track) tracks.push_back(*track);
  }
  return tracks;
}

cv::Mat1b SprayedGround(const std::vector<WheelTrack>& tracks,
                        const Grid& grid,
                        const HazardOptions& options) {
  std::vector<Neighbours> neighbours;
  for (const WheelTrack& track : tracks) {
    neighbours.push_back(NearestOnEitherSide(track, tracks, options));
  }
  cv::Mat1b mask = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  for (size_t i = 0; i < tracks.size(); ++i) {
    const double length = (tracks[i].end - tracks[i].start).norm();
    double working_width = 0.0;
    for (const std::optional<Neighbour>& side : neighbours[i]) {
      if (!side) continue;
      working_width = std::max(
          {working_width, std::abs(side->beside.across), WidestGap(neighbours[side->index])});
      Fill(tracks[i],
           {.first = std::max(0.0, side->beside.first),
            .last = std::min(length, side->beside.last),
            .right = std::min(0.0, side->beside.across),
            .left = std::max(0.0, side->beside.across)},
           grid,
           mask);
    }
    if (working_width == 0.0) continue;
    const double reach = 0.5 * working_width + options.sprayed_margin_m;
    Fill(tracks[i], {-reach, length + reach, -reach, reach}, grid, mask);
  }
  return mask;
}

}  // namespace freelsd
