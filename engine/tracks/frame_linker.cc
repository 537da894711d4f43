#include "engine/tracks/frame_linker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/tracks/verification.h"

namespace freelsd {
namespace {

// Number of latest frames that keep descriptors: a survey of several lines, about 60 MB.
constexpr size_t kNumDescribedFrames = 300;
// Frames farther apart than this many image diagonals on the ground do not overlap (with tilt).
constexpr double kMaxReachDiagonals = 0.9;
// Corners are refilled when fewer than this share is left, not after every loss.
constexpr double kRefillRatio = 0.8;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Pixel in `to` of the ground point at a pixel of `from`.
std::optional<Eigen::Vector2d> Transfer(const FrameMemory& memory,
                                        const Eigen::Vector2d& point,
                                        const std::pair<Rigid3d, Rigid3d>& from_to,
                                        double ground_height) {
  const auto& [world_from_first, world_from_second] = from_to;
  const Eigen::Vector3d ray = world_from_first.rotation * memory.rig.camera.RayFromImage(point);
  const double down = ground_height - world_from_first.translation.z();
  if (ray.z() > -0.05 || down > 0.0) return std::nullopt;
  const Eigen::Vector3d ground = world_from_first.translation + ray * (down / ray.z());
  return memory.rig.camera.ImageFromCamera(Inverse(world_from_second) * ground);
}

// Predicted pixels of the previous frame's points; empty if the poses are unknown.
std::vector<Eigen::Vector2d> PredictPoints(const FrameMemory& memory,
                                           const std::vector<Eigen::Vector2d>& points,
                                           std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const FrameRecord &from = memory.frames[newest - 1], &to = memory.frames[newest];
  if (!ground_height || !from.world_from_camera || !to.world_from_camera) return {};
  std::vector<Eigen::Vector2d> predicted;
  for (const Eigen::Vector2d& point : points) {
    const std::optional<Eigen::Vector2d> there =
        Transfer(memory, point, {*from.world_from_camera, *to.world_from_camera}, *ground_height);
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

void Describe(FrameRecord& record, const TrackingImage& image, const TracksOptions& options) {
  if (!record.descriptors.empty()) return;
  const DescribedPoints described = DescribeKeypoints(image, options);
  record.first_described = static_cast<int>(record.points.size());
  record.points.insert(record.points.end(), described.points.begin(), described.points.end());
  record.descriptors = described.descriptors;
}

// Points to follow: those on tracks first, because long tracks are more valuable.
std::vector<int> ChooseCorners(const FrameMemory& memory, size_t frame) {
  const int num_points = static_cast<int>(memory.frames[frame].points.size());
  std::vector<int> chosen, spare;
  for (int point = 0; point < num_points; ++point) {
    (memory.table.HasTrack(frame, point) ? chosen : spare).push_back(point);
  }
  chosen.insert(chosen.end(), spare.begin(), spare.end());
  if (num_points > memory.options.max_num_corners) chosen.resize(memory.options.max_num_corners);
  return chosen;
}

// The predecessor, then the nearest described frames.
std::vector<size_t> MatchPartners(const FrameMemory& memory, std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  const Eigen::Vector3d here = memory.frames[newest].PriorPosition();
  const Camera& camera = memory.rig.camera;
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i + 1 < newest; ++i) {
    if (memory.frames[i].descriptors.empty()) continue;
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

}  // namespace

void FrameLinker::LinkNewest(FrameMemory& memory, std::optional<double> ground_height) {
  memory.table.AddFrame();
  previous_image_ = std::move(image_);
  image_ = ReduceForTracking(memory.frames.back().frame.image, memory.options);
  if (memory.frames.size() > kNumDescribedFrames) {
    memory.frames[memory.frames.size() - 1 - kNumDescribedFrames].descriptors.release();
  }
  if (memory.frames.size() < 2) return;
  if (ShouldFollow(memory, ground_height) && LinkByFollowing(memory, ground_height)) return;
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
  Refill(memory, newest - 1);
  FrameRecord &from = memory.frames[newest - 1], &to = memory.frames[newest];
  const std::vector<int> chosen = ChooseCorners(memory, newest - 1);
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(chosen.size());
  for (const int index : chosen) corners.push_back(from.points[index]);
  const std::vector<Eigen::Vector2d> guesses = PredictPoints(memory, corners, ground_height);
  previous_image_ = WithPyramid(std::move(previous_image_));
  image_ = WithPyramid(std::move(image_));
  const auto followed = FollowCorners(previous_image_, image_, corners, guesses, memory.options);
  std::vector<IndexPair> matches;
  std::vector<double> flows;
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!followed[i]) continue;
    matches.push_back({static_cast<int>(to.points.size()), chosen[i]});
    to.points.push_back(*followed[i]);
    flows.push_back((*followed[i] - corners[i]).norm() / memory.rig.camera.width_px);
  }
  if (!AcceptLink(memory, newest, newest - 1, matches, image_.scale)) {
    to.points.clear();
    return false;
  }
  last_flow_ratio_ = Median(flows);
  return true;
}

void FrameLinker::Refill(FrameMemory& memory, size_t frame) const {
  std::vector<Eigen::Vector2d>& points = memory.frames[frame].points;
  if (static_cast<double>(points.size()) >= kRefillRatio * memory.options.max_num_corners) return;
  const std::vector<Eigen::Vector2d> fresh = FindCorners(previous_image_, points, memory.options);
  points.insert(points.end(), fresh.begin(), fresh.end());
}

void FrameLinker::LinkByDescriptors(FrameMemory& memory, std::optional<double> ground_height) {
  const size_t newest = memory.frames.size() - 1;
  Describe(memory.frames[newest], image_, memory.options);
  Describe(memory.frames[newest - 1], previous_image_, memory.options);
  last_flow_ratio_.reset();
  for (const size_t other : MatchPartners(memory, ground_height)) {
    MatchPair(memory, newest, other);
  }
}

void FrameLinker::MatchPair(FrameMemory& memory, size_t newest, size_t other) {
  const FrameRecord &record = memory.frames[newest], &neighbour = memory.frames[other];
  std::vector<IndexPair> matches = MatchDescriptors(record.descriptors, neighbour.descriptors);
  std::vector<double> flows;
  for (IndexPair& match : matches) {
    match.a += record.first_described;
    match.b += neighbour.first_described;
    flows.push_back((record.points[match.a] - neighbour.points[match.b]).norm() /
                    memory.rig.camera.width_px);
  }
  if (!AcceptLink(memory, newest, other, matches, image_.scale)) return;
  if (other + 1 == newest) last_flow_ratio_ = Median(flows);
}

}  // namespace freelsd
