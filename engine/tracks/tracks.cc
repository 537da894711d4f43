#include "engine/tracks/tracks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "engine/tracks/attitude/attitude.h"
#include "engine/tracks/coarse_depth.h"
#include "engine/tracks/frame_linker.h"
#include "engine/tracks/frame_memory.h"
#include "engine/tracks/ground/ground.h"

namespace freelsd {
namespace {

// Least size of a trusted component of frames without attitude; when overdue, two suffice.
constexpr size_t kMinComponentSize = 3;
constexpr size_t kMinComponentSizeWhenOverdue = 2;
// A first height with a larger deviation (share of the height) waits for more parallax.
constexpr double kMaxHeightSdRatio = 0.2;
// Limit when overdue. Beyond it the motion looks like a hover, and the height stays unknown.
constexpr double kMaxHeightSdRatioWhenOverdue = 0.5;
// Error of heights from planar alignment: relief, tilt, GPS over one baseline.
constexpr double kEstimatedHeightSdRatio = 0.1;
// Deviation of the plane that replaces missing landmarks, as a share of the height.
constexpr double kPlaneHeightSdRatio = 0.1;
// Largest tilt of the mount for a camera without attitude.
constexpr double kMaxMountTiltDeg = 25.0;
// Ground at world z = 0 (take-off) is assumed only if the camera is clearly above it.
constexpr double kMinHeightOverTakeOffM = 5.0;

enum class Urgency { kPatient, kOverdue };

void CheckImage(const Frame& frame, const Camera& camera) {
  const cv::Mat& image = frame.image;
  if (image.cols != camera.width_px || image.rows != camera.height_px) {
    std::ostringstream message;
    message << "frame " << frame.id << ": image is " << image.cols << "x" << image.rows
            << ", camera says " << camera.width_px << "x" << camera.height_px;
    throw std::invalid_argument(message.str());
  }
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3) {
    throw std::invalid_argument("frame " + frame.id + ": image must be 8 bit, grey or BGR");
  }
}

bool LooksDown(const Rig& rig) {
  const Eigen::Vector3d axis_in_body = rig.body_from_camera.rotation * Eigen::Vector3d::UnitZ();
  return axis_in_body.z() > std::cos(RadFromDeg(kMaxMountTiltDeg));
}

}  // namespace

struct Tracks::State {
  FrameMemory memory;
  FrameLinker linker;
  GroundFilter ground;
  std::vector<View> views;
  // Landmarks per frame with the current poses and tracks; cleared when either changes.
  mutable std::map<size_t, std::vector<CoarseLandmark>> landmarks;
  std::vector<size_t> frame_of_view;
  // Views whose poses changed since their heights were computed.
  std::set<size_t> replaced_views;

  void Remember(Frame frame);
  std::vector<ReadyFrame> Settle(Urgency urgency);
  bool SettleOriented(size_t frame, Urgency urgency);
  bool SettleComponent(const std::vector<size_t>& component, Urgency urgency);
  std::optional<double> FindHeight(size_t frame, Urgency urgency);
  void CorrectAttitude(FrameRecord& record, double turn);
  void MakeView(size_t frame, double height_above_ground);
  ReadyFrame HandOut(size_t frame);
  ReadyFrame GiveUp(size_t frame);
  std::string ReasonToGiveUp(const FrameRecord& record) const;
  std::vector<size_t> WaitingFrames() const;
  void CopyObservations();
  void RefreshHeights();
  const std::vector<CoarseLandmark>& LandmarksOf(size_t frame) const;
};

const std::vector<CoarseLandmark>& Tracks::State::LandmarksOf(size_t frame) const {
  const auto found = landmarks.find(frame);
  if (found != landmarks.end()) return found->second;
  return landmarks.emplace(frame, TriangulateLandmarks(memory, frame)).first->second;
}

std::vector<size_t> Tracks::State::WaitingFrames() const {
  std::vector<size_t> waiting;
  for (size_t i = 0; i < memory.frames.size(); ++i) {
    if (memory.frames[i].is_waiting) waiting.push_back(i);
  }
  return waiting;
}

void Tracks::State::Remember(Frame frame) {
  FrameRecord record;
  record.attitude_sd_deg = frame.prior.attitude_sd_deg;
  if (frame.prior.world_from_body) {
    const Rigid3d world_from_body{*frame.prior.world_from_body, frame.prior.position_in_world};
    record.world_from_camera = world_from_body * memory.rig.body_from_camera;
  }
  record.frame = std::move(frame);
  memory.frames.push_back(std::move(record));
  const FrameRecord& newest = memory.frames.back();
  std::optional<double> ground_height = ground.Height();
  if (newest.frame.height_above_ground) {
    ground_height = newest.PriorPosition().z() - *newest.frame.height_above_ground;
  }
  linker.LinkNewest(memory, ground_height);
  landmarks.clear();
}

// Height of the camera above ground: given, or from landmarks and earlier ground.
std::optional<double> Tracks::State::FindHeight(size_t frame, Urgency urgency) {
  const FrameRecord& record = memory.frames[frame];
  const Eigen::Vector3d position = record.world_from_camera->translation;
  if (record.frame.height_above_ground) {
    ground.Restart(position, position.z() - *record.frame.height_above_ground);
    return record.frame.height_above_ground;
  }
  if (memory.options.assume_ground_plane && position.z() > kMinHeightOverTakeOffM) {
    return position.z();
  }
  GroundFilter updated = ground;
  updated.MoveTo(position);
  if (const auto seen = GroundFromLandmarks(LandmarksOf(frame), record)) updated.Update(*seen);
  if (!updated.Height()) return std::nullopt;
  const double height = position.z() - *updated.Height();
  const double max_sd_ratio =
      urgency == Urgency::kPatient ? kMaxHeightSdRatio : kMaxHeightSdRatioWhenOverdue;
  const bool is_known = !views.empty() || updated.Sd() < max_sd_ratio * height;
  if (height <= 0.0 || !is_known) return std::nullopt;
  ground = updated;
  return height;
}

void Tracks::State::CorrectAttitude(FrameRecord& record, double turn) {
  TurnFrame(record, turn);
  record.attitude_source = AttitudeSource::kCorrected;
  std::ostringstream note;
  note << "given yaw disagrees with the matches by " << std::lround(std::abs(DegFromRad(turn)))
       << " deg; the matches' is used";
  record.note = note.str();
  landmarks.clear();
}

bool Tracks::State::SettleOriented(size_t frame, Urgency urgency) {
  FrameRecord& record = memory.frames[frame];
  // The first frame waits for the second, which can confirm its attitude.
  const bool is_alone = memory.frames.size() == 1;
  if (is_alone && urgency == Urgency::kPatient) return false;
  if (record.attitude_source == AttitudeSource::kGiven) {
    if (const std::optional<double> turn = NeededTurn(memory, frame)) {
      CorrectAttitude(record, *turn);
    }
  }
  const std::optional<double> height = FindHeight(frame, urgency);
  if (height) MakeView(frame, *height);
  return height.has_value();
}

bool Tracks::State::SettleComponent(const std::vector<size_t>& component, Urgency urgency) {
  const size_t num_waiting = WaitingFrames().size();
  const bool is_full = num_waiting >= static_cast<size_t>(memory.options.max_num_waiting_frames);
  const bool is_overdue = urgency == Urgency::kOverdue;
  const size_t min_size = is_overdue ? kMinComponentSizeWhenOverdue : kMinComponentSize;
  if (!LooksDown(memory.rig)) return false;
  if (!HasPosedNeighbour(memory, component)) {
    if (component.size() < min_size || !(is_full || is_overdue)) return false;
  }
  const std::vector<AlignmentFrame> solved = SolveAttitudes(memory, component);
  bool is_any_solved = false;
  for (size_t i = 0; i < component.size(); ++i) {
    if (!solved[i].is_solved) continue;
    FrameRecord& record = memory.frames[component[i]];
    record.world_from_camera = Rigid3d{solved[i].world_from_camera, solved[i].position_in_world};
    record.attitude_source = AttitudeSource::kEstimated;
    record.attitude_sd_deg = memory.options.nadir_sd_deg;
    record.note = "no attitude given: estimated from matches";
    const double height = solved[i].height_above_ground;
    ground.MoveTo(solved[i].position_in_world);
    ground.Update({solved[i].position_in_world.z() - height, kEstimatedHeightSdRatio * height});
    MakeView(component[i], height);
    is_any_solved = true;
  }
  return is_any_solved;
}

void Tracks::State::MakeView(size_t frame, double height_above_ground) {
  FrameRecord& record = memory.frames[frame];
  record.height_above_ground = height_above_ground;
  record.view = views.size();
  record.is_waiting = false;
  record.links.clear();
  View view;
  view.frame_id = record.frame.id;
  view.timestamp_us = record.frame.timestamp_us;
  view.world_from_camera = *record.world_from_camera;
  view.prior_position_in_world = record.PriorPosition();
  if (record.frame.prior.world_from_body) {
    view.prior_position_in_world +=
        *record.frame.prior.world_from_body * memory.rig.body_from_camera.translation;
  }
  view.prior_world_from_camera = record.world_from_camera->rotation;
  view.position_sd_m = record.frame.prior.position_sd_m;
  view.attitude_sd_deg = record.attitude_sd_deg;
  view.attitude_source = record.attitude_source;
  view.height_above_ground = height_above_ground;
  view.observations = memory.table.ObservationsOf(frame);
  views.push_back(std::move(view));
  frame_of_view.push_back(frame);
  landmarks.clear();
}

ReadyFrame Tracks::State::HandOut(size_t frame) {
  FrameRecord& record = memory.frames[frame];
  ReadyFrame ready{record.frame, record.view, record.note};
  record.frame.image.release();
  return ready;
}

std::string Tracks::State::ReasonToGiveUp(const FrameRecord& record) const {
  if (record.world_from_camera) {
    return "height above ground unknown: none given, and no neighbour to triangulate with";
  }
  if (!LooksDown(memory.rig)) return "no attitude given, and the camera does not look down";
  if (!record.links.empty()) {
    return "no attitude given, and the matches with its neighbours do not determine one";
  }
  return "no attitude given, and fewer than " +
         std::to_string(memory.options.min_num_verified_matches) + " matches with any neighbour";
}

ReadyFrame Tracks::State::GiveUp(size_t frame) {
  FrameRecord& record = memory.frames[frame];
  record.note = ReasonToGiveUp(record);
  record.is_waiting = false;
  record.links.clear();
  record.world_from_camera.reset();
  landmarks.clear();
  return HandOut(frame);
}

// Turns waiting frames into views in rounds, because a new view can help its neighbours.
std::vector<ReadyFrame> Tracks::State::Settle(Urgency urgency) {
  const std::vector<size_t> waiting = WaitingFrames();
  bool has_progress = true;
  while (has_progress) {
    has_progress = false;
    for (const size_t frame : waiting) {
      const FrameRecord& record = memory.frames[frame];
      if (!record.is_waiting || !record.world_from_camera) continue;
      has_progress = SettleOriented(frame, urgency) || has_progress;
    }
    for (const std::vector<size_t>& component : WaitingComponents(memory)) {
      has_progress = SettleComponent(component, urgency) || has_progress;
    }
  }
  std::vector<ReadyFrame> ready;
  for (const size_t frame : waiting) {
    if (!memory.frames[frame].is_waiting) ready.push_back(HandOut(frame));
  }
  return ready;
}

void Tracks::State::CopyObservations() {
  for (const size_t frame : memory.table.TakeChangedFrames()) {
    const std::optional<size_t> view = memory.frames[frame].view;
    if (view) views[*view].observations = memory.table.ObservationsOf(frame);
  }
}

void Tracks::State::RefreshHeights() {
  for (const size_t view : replaced_views) {
    FrameRecord& record = memory.frames[frame_of_view[view]];
    if (record.frame.height_above_ground || memory.options.assume_ground_plane) continue;
    const auto seen = GroundFromLandmarks(LandmarksOf(frame_of_view[view]), record);
    if (!seen) continue;
    record.height_above_ground = record.world_from_camera->translation.z() - seen->z;
    views[view].height_above_ground = *record.height_above_ground;
  }
  replaced_views.clear();
}

Tracks::Tracks(const Rig& rig, const TracksOptions& options) : state_(std::make_unique<State>()) {
  options.Check();
  rig.camera.Check();
  state_->memory.rig = rig;
  state_->memory.options = options;
}

Tracks::~Tracks() = default;
Tracks::Tracks(Tracks&&) noexcept = default;
Tracks& Tracks::operator=(Tracks&&) noexcept = default;

std::vector<ReadyFrame> Tracks::Add(Frame frame) {
  CheckImage(frame, state_->memory.rig.camera);
  state_->RefreshHeights();
  state_->Remember(std::move(frame));
  std::vector<ReadyFrame> ready = state_->Settle(Urgency::kPatient);
  const auto max_waiting = static_cast<size_t>(state_->memory.options.max_num_waiting_frames);
  if (state_->WaitingFrames().size() > max_waiting) {
    for (ReadyFrame& frame_now : state_->Settle(Urgency::kOverdue)) {
      ready.push_back(std::move(frame_now));
    }
    while (state_->WaitingFrames().size() > max_waiting) {
      ready.push_back(state_->GiveUp(state_->WaitingFrames().front()));
    }
  }
  state_->CopyObservations();
  return ready;
}

std::vector<ReadyFrame> Tracks::Flush() {
  state_->RefreshHeights();
  std::vector<ReadyFrame> ready = state_->Settle(Urgency::kOverdue);
  for (const size_t frame : state_->WaitingFrames()) ready.push_back(state_->GiveUp(frame));
  state_->CopyObservations();
  return ready;
}

const std::vector<View>& Tracks::views() const { return state_->views; }
const Camera& Tracks::camera() const { return state_->memory.rig.camera; }

void Tracks::SetPose(size_t view, const Rigid3d& world_from_camera, const Readout& readout) {
  View& changed = state_->views.at(view);
  FrameRecord& record = state_->memory.frames[state_->frame_of_view[view]];
  const double climb =
      world_from_camera.translation.z() - changed.world_from_camera.translation.z();
  changed.world_from_camera = world_from_camera;
  changed.height_above_ground = std::max(changed.height_above_ground + climb, 0.1);
  changed.readout = record.readout = readout;
  record.world_from_camera = world_from_camera;
  record.height_above_ground = changed.height_above_ground;
  state_->replaced_views.insert(view);
  state_->landmarks.clear();
}

std::optional<GroundPoint> Tracks::GroundAt(size_t view,
                                            const Eigen::Vector2d& point_in_image) const {
  const View& seen_from = state_->views.at(view);
  const Camera camera = state_->memory.rig.camera.With(seen_from.readout);
  const Rigid3d& world_from_camera = seen_from.world_from_camera;
  GroundHeight height{world_from_camera.translation.z() - seen_from.height_above_ground,
                      kPlaneHeightSdRatio * seen_from.height_above_ground};
  if (!state_->memory.options.assume_ground_plane) {
    const auto near = HeightNear(state_->LandmarksOf(state_->frame_of_view[view]),
                                 point_in_image,
                                 state_->memory.options.num_nearest_tracks);
    if (near) height = *near;
  }
  const auto point = IntersectGround(camera, world_from_camera, point_in_image, height.z);
  if (!point) return std::nullopt;
  return GroundPoint{*point, height.sd_m};
}

}  // namespace freelsd
