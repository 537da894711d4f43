#include "engine/cover/wheel_tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/cover/ruts.h"

namespace freelsd {
namespace {

// Places of a track are binned in squares of this side. A larger gap separates tracks.
constexpr double kSquareM = 0.5;
constexpr int kMaxGapSquares = 4;
constexpr double kMaxBendRad = 0.3;
// Largest distance of a place from the line through its track.
constexpr double kMaxWaveM = 0.75;
// Two places per metre would fill every square.
constexpr double kMinPlacesPerM = 1.4;
constexpr int kNumFits = 3;
// Largest number of straight tracks searched in one connected set of places.
constexpr int kMaxNumTries = 400;
constexpr double kParallelRad = 0.17;
// A mower's track has a close neighbour along at least this share of its length.
constexpr double kMinMowingRatio = 0.5;
// Closer tracks are duplicates.
constexpr double kSameTrackM = 2.5;
// Neighbours overlap by at least this share of the shorter one.
constexpr double kMinOverlapRatio = 0.3;

// The place of highest contrast in each square, by row and column of the square.
using Squares = std::map<std::pair<int, int>, TrackPlace>;

Squares GatherPlaces(const std::vector<TrackPlace>& places, double cell_size_m) {
  Squares squares;
  for (const TrackPlace& found : places) {
    const Eigen::Vector2d square = found.place * cell_size_m / kSquareM;
    const std::pair<int, int> key(int(std::floor(square.y())), int(std::floor(square.x())));
    const auto [it, is_new] = squares.try_emplace(key, found);
    if (!is_new && found.contrast > it->second.contrast) it->second = found;
  }
  return squares;
}

double AngleBetween(double a, double b) {
  const double turn = std::abs(a - b);
  return std::min(turn, kPi - turn);
}

// Union-find over the indices of the places.
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
    // Only squares after this one: those before have already linked to it.
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
  gathered.reserve(by_root.size());
  for (auto& [root, chain] : by_root) gathered.push_back(std::move(chain));
  return gathered;
}

// A straight line, in cells of the orthophoto.
struct Line {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();

  double Turn() const { return std::atan2(along.y(), along.x()); }
  double Along(const TrackPlace& place) const { return (place.place - middle).dot(along); }
  double Across(const TrackPlace& place) const {
    return (place.place - middle).dot(Eigen::Vector2d(-along.y(), along.x()));
  }
};

Line LineThrough(const std::vector<TrackPlace>& places) {
  Line line;
  for (const TrackPlace& place : places) {
    line.middle += place.place / static_cast<double>(places.size());
  }
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const TrackPlace& place : places) {
    moments += (place.place - line.middle) * (place.place - line.middle).transpose();
  }
  const double turn = 0.5 * std::atan2(2.0 * moments(0, 1), moments(0, 0) - moments(1, 1));
  line.along = {std::cos(turn), std::sin(turn)};
  return line;
}

bool IsOn(const Line& line, const TrackPlace& place, double cell_size_m) {
  return std::abs(line.Across(place)) * cell_size_m <= kMaxWaveM &&
         AngleBetween(std::fmod(line.Turn() + kPi, kPi), place.direction) <= kMaxBendRad;
}

struct StraightTrack {
  Line line;
  // All places on the line.
  std::vector<TrackPlace> places;
};

// The straight track through the clearest place. The line starts in the direction of that place and
// is then fitted to the places on it.
StraightTrack ClearestTrack(const std::vector<TrackPlace>& places, double cell_size_m) {
  const TrackPlace& clearest =
      *std::max_element(places.begin(), places.end(), [](const auto& a, const auto& b) {
        return a.contrast < b.contrast;
      });
  StraightTrack track;
  track.line = {clearest.place, {std::cos(clearest.direction), std::sin(clearest.direction)}};
  for (int round = 0; round < kNumFits; ++round) {
    if (track.places.size() >= 2) track.line = LineThrough(track.places);
    track.places.clear();
    std::copy_if(places.begin(),
                 places.end(),
                 std::back_inserter(track.places),
                 [&](const TrackPlace& place) { return IsOn(track.line, place, cell_size_m); });
  }
  return track;
}

// Nothing if the track is too short or has too many gaps.
std::optional<WheelTrack> TrackOf(const std::vector<TrackPlace>& places,
                                  const Grid& grid,
                                  const CoverOptions& options) {
  if (places.size() < 2) return std::nullopt;
  const Line line = LineThrough(places);
  double first = 0.0, last = 0.0;
  for (const TrackPlace& place : places) {
    first = std::min(first, line.Along(place));
    last = std::max(last, line.Along(place));
  }
  const double length_m = (last - first) * grid.cell_size_m;
  if (length_m < options.min_track_length_m) return std::nullopt;
  if (static_cast<double>(places.size()) < kMinPlacesPerM * length_m) return std::nullopt;
  const auto in_world = [&](double along) -> Eigen::Vector2d {
    const Eigen::Vector2d place = line.middle + along * line.along;
    return grid.north_west_in_world +
           grid.cell_size_m * Eigen::Vector2d(place.x() + 0.5, -(place.y() + 0.5));
  };
  return WheelTrack{in_world(first), in_world(last)};
}

// The straight tracks in a connected set of places, which chance may have joined.
std::vector<WheelTrack> TracksThrough(std::vector<TrackPlace> chain,
                                      const Grid& grid,
                                      const CoverOptions& options) {
  const double min_num_places = kMinPlacesPerM * options.min_track_length_m;
  std::vector<WheelTrack> tracks;
  for (int i = 0; i < kMaxNumTries && static_cast<double>(chain.size()) >= min_num_places; ++i) {
    const StraightTrack found = ClearestTrack(chain, grid.cell_size_m);
    if (const auto track = TrackOf(found.places, grid, options)) tracks.push_back(*track);
    const size_t num_used = std::erase_if(
        chain, [&](const TrackPlace& place) { return IsOn(found.line, place, grid.cell_size_m); });
    if (num_used > 0) continue;
    // Two adjacent chance places can misdirect the line: only the clearest one is dropped then.
    const auto clearest =
        std::max_element(chain.begin(), chain.end(), [](const auto& a, const auto& b) {
          return a.contrast < b.contrast;
        });
    chain.erase(clearest);
  }
  return tracks;
}

// A track in the frame of another: its distance to the left, and its start and end along the other.
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

// Nothing unless the track is parallel and its distance lies within these limits.
std::optional<Beside> NeighbourWithin(const WheelTrack& track,
                                      const WheelTrack& other,
                                      double min_distance,
                                      double max_distance) {
  const Eigen::Vector2d own = track.end - track.start, its = other.end - other.start;
  const double sine = std::abs(own.x() * its.y() - own.y() * its.x()) / (own.norm() * its.norm());
  if (sine > std::sin(kParallelRad)) return std::nullopt;
  const Beside beside = BesideOf(track, other);
  const double distance = std::abs(beside.across);
  if (distance < min_distance || distance > max_distance) return std::nullopt;
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
                               const CoverOptions& options) {
  Neighbours nearest;
  for (size_t i = 0; i < tracks.size(); ++i) {
    const std::optional<Beside> beside =
        NeighbourWithin(track, tracks[i], options.min_working_width_m, options.max_working_width_m);
    if (!beside) continue;
    std::optional<Neighbour>& side = nearest[beside->across > 0.0 ? 1 : 0];
    if (!side || std::abs(beside->across) < std::abs(side->beside.across)) side = {i, *beside};
  }
  return nearest;
}

// Whether close tracks lie to the right and to the left.
std::array<bool, 2> HasCloseOnes(const WheelTrack& track,
                                 const std::vector<WheelTrack>& tracks,
                                 const CoverOptions& options) {
  std::array<bool, 2> has_close{};
  for (const WheelTrack& other : tracks) {
    const auto beside = NeighbourWithin(track, other, kSameTrackM, options.min_working_width_m);
    if (!beside || std::abs(beside->across) >= options.min_working_width_m) continue;
    // A short chance fragment must not turn a sprayer's track into a mower's.
    const double length = (track.end - track.start).norm();
    const double overlap = std::min(beside->last, length) - std::max(beside->first, 0.0);
    if (overlap >= kMinMowingRatio * length) {
      has_close[beside->across > 0.0 ? 1 : 0] = true;
    }
  }
  return has_close;
}

// Mowers and tedders drive to and fro. Their tracks therefore have close neighbours on both sides.
// An outermost track has only one neighbour, but that neighbour has two. A sprayer's tracks lie
// close only near the headland.
std::vector<WheelTrack> WithoutMowing(const std::vector<WheelTrack>& tracks,
                                      const CoverOptions& options) {
  std::vector<WheelTrack> between;
  for (const WheelTrack& track : tracks) {
    const std::array<bool, 2> has_close = HasCloseOnes(track, tracks, options);
    if (has_close[0] && has_close[1]) between.push_back(track);
  }
  std::vector<WheelTrack> kept;
  for (const WheelTrack& track : tracks) {
    const std::array<bool, 2> all = HasCloseOnes(track, tracks, options);
    const std::array<bool, 2> mown = HasCloseOnes(track, between, options);
    const bool is_mowing = (all[0] && all[1]) || mown[0] || mown[1];
    if (!is_mowing) kept.push_back(track);
  }
  return kept;
}

// The last pass may lie closer to the headland than one working width. The widest gap is therefore
// more reliable.
double WidestGap(const Neighbours& neighbours) {
  double widest = 0.0;
  for (const std::optional<Neighbour>& side : neighbours) {
    if (side) widest = std::max(widest, std::abs(side->beside.across));
  }
  return widest;
}

// The rectangle along a track: start, end, and reach to its right and left.
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

std::vector<WheelTrack> FindWheelTracks(const Orthophoto& photo, const CoverOptions& options) {
  std::vector<WheelTrack> tracks;
  if (photo.image.empty()) return tracks;
  const Squares squares = GatherPlaces(RutPairs(photo, options), photo.grid.cell_size_m);
  for (const auto& chain : ChainsOf(squares)) {
    const std::vector<WheelTrack> found = TracksThrough(chain, photo.grid, options);
    tracks.insert(tracks.end(), found.begin(), found.end());
  }
  return tracks;
}

cv::Mat1b SprayedGround(const std::vector<WheelTrack>& all_tracks,
                        const Grid& grid,
                        const CoverOptions& options) {
  const std::vector<WheelTrack> tracks = WithoutMowing(all_tracks, options);
  std::vector<Neighbours> neighbours;
  neighbours.reserve(tracks.size());
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
    }
    if (working_width == 0.0) continue;
    // Uses every parallel track, because the nearest may be a chance fragment.
    for (const WheelTrack& other : tracks) {
      const auto beside = NeighbourWithin(
          tracks[i], other, options.min_working_width_m, options.max_working_width_m);
      if (!beside) continue;
      Fill(tracks[i],
           {.first = std::max(0.0, beside->first),
            .last = std::min(length, beside->last),
            .right = std::min(0.0, beside->across),
            .left = std::max(0.0, beside->across)},
           grid,
           mask);
    }
    const double reach = 0.5 * working_width + options.sprayed_margin_m;
    Fill(tracks[i], {-reach, length + reach, -reach, reach}, grid, mask);
  }
  return mask;
}

}  // namespace freelsd
