#include "engine/tracks/frame_linker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "engine/tracks/coarse_depth.h"
#include "engine/tracks/prediction.h"
#include "engine/tracks/verification.h"

namespace freelsd {
namespace {

// Number of latest frames that keep image and descriptors: a survey of several lines, 0.4 to 0.6 MB
// each.
constexpr size_t kNumRememberedFrames = 240;
// Frames farther apart than this many image diagonals on the ground do not overlap (with tilt).
constexpr double kMaxReachDiagonals = 0.9;
// Corners are refilled when fewer than this share is left, not after every loss.
constexpr double kRefillRatio = 0.8;
// A smaller predicted overlap of two photographs holds too few corners.
constexpr double kMinPredictedOverlap = 0.1;

PosedImage PosedImageOf(const FrameMemory& memory, size_t frame) {
  const FrameRecord& record = memory.frames[frame];
  return {record.image, memory.CameraOf(frame), *record.world_from_camera};
}

// Predicted pixels of the previous frame's points; empty if the poses are unknown.
std::vector<Eigen::Vector2d> PredictPoints(const FrameMemory& memory,
                                           const std::vector<Eigen::Vector2d>& points,
                                           std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const FrameRecord &from = memory.frames[newest - 1], &to = memory.frames[newest];
  if (!ground_height || !from.world_from_camera || !to.world_from_camera) return {};
  const PosedImage posed_from = PosedImageOf(memory, newest - 1);
  const PosedImage posed_to = PosedImageOf(memory, newest);
  std::vector<Eigen::Vector2d> predicted;
  for (const Eigen::Vector2d& point : points) {
    const std::optional<Eigen::Vector2d> there =
        TransferOverGround(posed_from, posed_to, point, *ground_height);
    if (!there) return {};
    predicted.push_back(*there);
  }
  return predicted;
}

std::optional<double> PredictedFlowRatio(const FrameMemory& memory,
                                         std::optional<double> ground_height) {
  const Camera& camera = memory.rig.camera;
  const Eigen::Vector2d centre(0.5 * camera.width_px, 0.5 * camera.height_px);
  const std::vector<Eigen::Vector2d> there = PredictPoints(memory, {centre}, ground_height);
  if (!there.empty()) return (there[0] - centre).norm() / camera.width_px;
  return std::nullopt;
}

// Ideal pixels at the scale of matching, in which the verification threshold is given.
Eigen::Vector2d MatchingPixel(const FrameMemory& memory, size_t frame, int point, double scale) {
  return memory.Normalized(frame, point) * (memory.rig.camera.MeanFocalPx() * scale);
}

// Adds verified links to both frames and the tracks; false if too few are verified.
bool AcceptLink(FrameMemory& memory,
                size_t newest,
                size_t other,
                const std::vector<IndexPair>& matches,
                double scale) {
  std::vector<Eigen::Vector2d> here, there;
  for (const IndexPair& match : matches) {
    here.push_back(MatchingPixel(memory, newest, match.a, scale));
    there.push_back(MatchingPixel(memory, other, match.b, scale));
  }
  const std::vector<int> verified = VerifyMatches(here,
                                                  there,
                                                  memory.options.max_verification_error_px,
                                                  memory.options.min_num_verified_matches);
  if (static_cast<int>(verified.size()) < memory.options.min_num_verified_matches) return false;
  Link forward{other, {}}, backward{newest, {}};
  FrameRecord &record = memory.frames[newest], &neighbour = memory.frames[other];
  for (const int index : verified) {
    const IndexPair& match = matches[index];
    forward.pairs.push_back(match);
    backward.pairs.push_back({match.b, match.a});
    memory.table.Join({newest, match.a, record.points[match.a]},
                      {other, match.b, neighbour.points[match.b]});
  }
  record.links.push_back(std::move(forward));
  if (neighbour.is_waiting) neighbour.links.push_back(std::move(backward));
  return true;
}

void Describe(FrameRecord& record, const TracksOptions& options) {
  if (!record.descriptors.empty()) return;
  const DescribedPoints described = DescribeKeypoints(record.image, options);
  record.first_described = static_cast<int>(record.points.size());
  record.points.insert(record.points.end(), described.points.begin(), described.points.end());
  record.descriptors = described.descriptors;
}

// Points to follow: those on tracks first, because long tracks are more valuable.
std::vector<int> ChooseCorners(const FrameMemory& memory, size_t frame, int max_count) {
  const int num_points = static_cast<int>(memory.frames[frame].points.size());
  std::vector<int> chosen, spare;
  for (int point = 0; point < num_points; ++point) {
    (memory.table.TrackOf(frame, point) ? chosen : spare).push_back(point);
  }
  chosen.insert(chosen.end(), spare.begin(), spare.end());
  if (num_points > max_count) chosen.resize(static_cast<size_t>(max_count));
  return chosen;
}

// Adds corners to a frame that has lost many.
void Refill(FrameRecord& record, int max_count) {
  if (static_cast<double>(record.points.size()) >= kRefillRatio * max_count) return;
  const std::vector<Eigen::Vector2d> fresh = FindCorners(record.image, record.points, max_count);
  record.points.insert(record.points.end(), fresh.begin(), fresh.end());
}

// Points of the newest frame by the track to which they belong.
std::map<int64_t, int> PointsByTrack(const FrameMemory& memory, size_t frame) {
  std::map<int64_t, int> points;
  for (int point = 0; point < static_cast<int>(memory.frames[frame].points.size()); ++point) {
    if (const auto track = memory.table.TrackOf(frame, point)) points[*track] = point;
  }
  return points;
}

// Matches of the newest frame with `other`. Points on tracks that the newest frame has already are
// not followed again; if they are the majority, none is.
std::vector<IndexPair> MatchOverGround(FrameMemory& memory,
                                       size_t other,
                                       const PosedImage& newest_image,
                                       const PlaneOverlap& overlap,
                                       double ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const std::map<int64_t, int> known = PointsByTrack(memory, newest);
  const std::vector<Eigen::Vector2d>& points = memory.frames[other].points;
  const PosedImage from = PosedImageOf(memory, other);
  std::vector<IndexPair> matches;
  std::vector<int> wanted;
  std::vector<Eigen::Vector2d> places, guesses;
  for (const int point : ChooseCorners(memory, other, memory.options.max_num_predicted_corners)) {
    const std::optional<int64_t> track = memory.table.TrackOf(other, point);
    const auto found = track ? known.find(*track) : known.end();
    if (found != known.end()) {
      matches.push_back({found->second, point});
      continue;
    }
    const Eigen::Vector2d& place = points[static_cast<size_t>(point)];
    const auto guess = TransferOverGround(from, newest_image, place, ground_height);
    if (!guess || !newest_image.camera.IsInside(*guess)) continue;
    wanted.push_back(point);
    places.push_back(place);
    guesses.push_back(*guess);
  }
  if (matches.size() > wanted.size()) return matches;
  const auto followed =
      FollowOverGround(from, newest_image, overlap, places, guesses, memory.options);
  std::vector<Eigen::Vector2d>& here = memory.frames[newest].points;
  for (size_t i = 0; i < followed.size(); ++i) {
    if (!followed[i]) continue;
    matches.push_back({static_cast<int>(here.size()), wanted[i]});
    here.push_back(*followed[i]);
  }
  return matches;
}

// The newest image with the attitude that its matches with `other` suggest.
void TurnByMatches(const FrameMemory& memory,
                   size_t other,
                   double ground_height,
                   PosedImage& newest_image) {
  const FrameRecord& record = memory.frames.back();
  const PosedImage from = PosedImageOf(memory, other);
  std::vector<Eigen::Vector2d> expected, found;
  for (const IndexPair& pair : record.links.back().pairs) {
    const Eigen::Vector2d& there = memory.frames[other].points[static_cast<size_t>(pair.b)];
    const auto guess = TransferOverGround(from, newest_image, there, ground_height);
    if (!guess) continue;
    expected.push_back(*guess);
    found.push_back(record.points[static_cast<size_t>(pair.a)]);
  }
  if (static_cast<int>(found.size()) < memory.options.min_num_verified_matches) return;
  newest_image.world_from_camera.rotation = TurnedToFit(newest_image, expected, found);
}

// The predecessor, then the nearest remembered frames.
std::vector<size_t> MatchPartners(const FrameMemory& memory, std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const Eigen::Vector3d here = memory.frames[newest].PriorPosition();
  const Camera& camera = memory.rig.camera;
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i + 1 < newest; ++i) {
    if (memory.frames[i].image.grey.empty()) continue;
    const double distance = (memory.frames[i].PriorPosition() - here).head<2>().norm();
    const double height = ground_height ? std::max(here.z() - *ground_height, 1.0) : 0.0;
    const double diagonal =
        height * std::hypot(camera.width_px, camera.height_px) / camera.MeanFocalPx();
    if (ground_height && distance > kMaxReachDiagonals * diagonal) continue;
    near.emplace_back(distance, i);
  }
  std::sort(near.begin(), near.end());
  std::vector<size_t> partners{newest - 1};
  for (const auto& [distance, index] : near) {
    if (static_cast<int>(partners.size()) > memory.options.max_num_match_partners) break;
    partners.push_back(index);
  }
  return partners;
}

// Remembered frames that show some of the same ground, the largest overlap first.
std::vector<size_t> OverlappingPartners(const FrameMemory& memory,
                                        const PosedImage& newest_image,
                                        double ground_height) {
  std::vector<std::pair<double, size_t>> by_overlap;
  for (const size_t other : MatchPartners(memory, ground_height)) {
    if (!memory.frames[other].world_from_camera) continue;
    const auto overlap =
        OverlapOverGround(PosedImageOf(memory, other), newest_image, ground_height);
    if (overlap && overlap->ratio >= kMinPredictedOverlap) {
      by_overlap.emplace_back(-overlap->ratio, other);
    }
  }
  std::sort(by_overlap.begin(), by_overlap.end());
  std::vector<size_t> partners;
  partners.reserve(by_overlap.size());
  for (const auto& [negative_ratio, other] : by_overlap) partners.push_back(other);
  return partners;
}

// False if too few matches are verified. The newest frame then has the points that it had.
bool LinkOverGround(FrameMemory& memory,
                    size_t other,
                    const PosedImage& newest_image,
                    double ground_height) {
  const size_t newest = memory.frames.size() - 1;
  std::vector<Eigen::Vector2d>& points = memory.frames[newest].points;
  const auto overlap = OverlapOverGround(PosedImageOf(memory, other), newest_image, ground_height);
  if (!overlap) return false;
  const size_t num_before = points.size();
  const std::vector<IndexPair> matches =
      MatchOverGround(memory, other, newest_image, *overlap, ground_height);
  const bool is_linked = AcceptLink(memory, newest, other, matches, newest_image.image.scale);
  if (!is_linked) points.resize(num_before);
  return is_linked;
}

}  // namespace

void FrameLinker::LinkNewest(FrameMemory& memory, std::optional<double> ground_height) {
  memory.table.AddFrame();
  FrameRecord& record = memory.frames.back();
  record.image = ReduceForTracking(record.frame.image, memory.options);
  const size_t num_frames = memory.frames.size();
  if (num_frames > kNumRememberedFrames) {
    FrameRecord& forgotten = memory.frames[num_frames - 1 - kNumRememberedFrames];
    forgotten.descriptors.release();
    forgotten.image = {};
  }
  if (num_frames < 2) return;
  if (num_frames > 2) memory.frames[num_frames - 3].image.pyramid.clear();
  if (ShouldFollow(memory, ground_height) && LinkByFollowing(memory, ground_height)) return;
  const bool is_predictable =
      ground_height && record.world_from_camera && memory.options.max_num_predicted_corners > 0;
  if (is_predictable && LinkByPrediction(memory, *ground_height)) return;
  LinkByDescriptors(memory, ground_height);
}

bool FrameLinker::ShouldFollow(const FrameMemory& memory,
                               std::optional<double> ground_height) const {
  const std::optional<double> predicted = PredictedFlowRatio(memory, ground_height);
  const std::optional<double> flow_ratio = predicted ? predicted : last_flow_ratio_;
  return flow_ratio && *flow_ratio < memory.options.max_klt_flow_ratio;
}

bool FrameLinker::LinkByFollowing(FrameMemory& memory, std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const int max_count = memory.options.max_num_corners;
  FrameRecord &from = memory.frames[newest - 1], &to = memory.frames[newest];
  Refill(from, max_count);
  const std::vector<int> chosen = ChooseCorners(memory, newest - 1, max_count);
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(chosen.size());
  for (const int index : chosen) corners.push_back(from.points[index]);
  const std::vector<Eigen::Vector2d> guesses = PredictPoints(memory, corners, ground_height);
  from.image = WithPyramid(std::move(from.image));
  to.image = WithPyramid(std::move(to.image));
  const auto followed = FollowCorners(from.image, to.image, corners, guesses, memory.options);
  std::vector<IndexPair> matches;
  std::vector<double> flows;
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!followed[i]) continue;
    matches.push_back({static_cast<int>(to.points.size()), chosen[i]});
    to.points.push_back(*followed[i]);
    flows.push_back((*followed[i] - corners[i]).norm() / memory.rig.camera.width_px);
  }
  if (!AcceptLink(memory, newest, newest - 1, matches, to.image.scale)) {
    to.points.clear();
    return false;
  }
  last_flow_ratio_ = Median(flows);
  return true;
}

// The first linked partner, which has the largest overlap, tells the error of the newest attitude.
bool FrameLinker::LinkByPrediction(FrameMemory& memory, double ground_height) {
  const size_t newest = memory.frames.size() - 1;
  FrameRecord& record = memory.frames[newest];
  record.image = WithPyramid(std::move(record.image));
  PosedImage image = PosedImageOf(memory, newest);
  bool is_linked = false;
  for (const size_t other : OverlappingPartners(memory, image, ground_height)) {
    Refill(memory.frames[other], memory.options.max_num_predicted_corners);
    if (!LinkOverGround(memory, other, image, ground_height)) continue;
    if (!is_linked) TurnByMatches(memory, other, ground_height, image);
    is_linked = true;
  }
  last_flow_ratio_.reset();
  if (is_linked) Refill(record, memory.options.max_num_predicted_corners);
  return is_linked;
}

void FrameLinker::LinkByDescriptors(FrameMemory& memory, std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  FrameRecord& record = memory.frames[newest];
  Describe(record, memory.options);
  last_flow_ratio_.reset();
  const std::vector<size_t> partners = MatchPartners(memory, ground_height);
  for (const size_t other : partners) Describe(memory.frames[other], memory.options);
  std::vector<std::vector<IndexPair>> matches(partners.size());
  cv::parallel_for_({0, static_cast<int>(partners.size())}, [&](const cv::Range& range) {
    for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
      matches[i] = MatchDescriptors(record.descriptors, memory.frames[partners[i]].descriptors);
    }
  });
  for (size_t i = 0; i < partners.size(); ++i) AcceptPair(memory, partners[i], matches[i]);
}

void FrameLinker::AcceptPair(FrameMemory& memory, size_t other, std::vector<IndexPair>& matches) {
  const size_t newest = memory.frames.size() - 1;
  const FrameRecord &record = memory.frames[newest], &neighbour = memory.frames[other];
  std::vector<double> flows;
  for (IndexPair& match : matches) {
    match.a += record.first_described;
    match.b += neighbour.first_described;
    flows.push_back((record.points[match.a] - neighbour.points[match.b]).norm() /
                    memory.rig.camera.width_px);
  }
  if (!AcceptLink(memory, newest, other, matches, record.image.scale)) return;
  if (other + 1 == newest) last_flow_ratio_ = Median(flows);
}

}  // namespace freelsd
