// EuRoC / ASL folders: mav0/cam0 (data.csv, sensor.yaml) and state_groundtruth_estimate0/data.csv.
#include <algorithm>
#include <charconv>

#include "api/import/number_text.h"
#include "api/import/poses/csv.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr int64_t kNsPerUs = 1000;
// Poses are not interpolated across a longer gap.
constexpr int64_t kMaxGapNs = 1'000'000'000;
// timestamp, position, quaternion.
constexpr size_t kNumPoseCells = 8;

int64_t TimeOf(const std::string& cell, const SideFile& file, int line) {
  const std::string text = WordsOf(cell).empty() ? "" : WordsOf(cell)[0];
  int64_t time_ns = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), time_ns);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size() || time_ns < 0) {
    throw InvalidSideFile(file, line, "the timestamp must be whole nanoseconds");
  }
  return time_ns;
}

std::vector<CsvLine> RowsOf(const SideFile& file) {
  try {
    std::vector<CsvLine> rows = ParseCsv(file.text);
    std::erase_if(rows, [](const CsvLine& row) { return row.cells[0].rfind('#', 0) == 0; });
    return rows;
  } catch (const std::invalid_argument& error) {
    throw InvalidSideFile(file, 0, error.what());
  }
}

// Timestamp in the file's name: "1403636579763555584.png".
std::optional<int64_t> TimeOfName(const std::string& image_id) {
  int64_t time_ns = 0;
  const size_t dot = std::min(image_id.find('.'), image_id.size());
  const auto result = std::from_chars(image_id.data(), image_id.data() + dot, time_ns);
  const bool is_time = dot > 0 && result.ec == std::errc() && result.ptr == image_id.data() + dot;
  return is_time ? std::optional<int64_t>(time_ns) : std::nullopt;
}

std::optional<Rigid3d> At(const std::vector<BodyPose>& poses, int64_t time_ns) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_ns, [](const BodyPose& pose, int64_t time) {
        return pose.timestamp_ns < time;
      });
  if (after == poses.end()) return std::nullopt;
  if (after->timestamp_ns == time_ns) return after->local_from_body;
  if (after == poses.begin()) return std::nullopt;
  const BodyPose& before = *(after - 1);
  const int64_t gap_ns = after->timestamp_ns - before.timestamp_ns;
  if (gap_ns > kMaxGapNs) return std::nullopt;
  const double t = static_cast<double>(time_ns - before.timestamp_ns) / static_cast<double>(gap_ns);
  const Rigid3d& a = before.local_from_body;
  const Rigid3d& b = after->local_from_body;
  return Rigid3d{a.rotation.slerp(t, b.rotation), (1.0 - t) * a.translation + t * b.translation};
}

std::vector<LocalPose> PosesAt(const std::map<std::string, int64_t>& image_times_ns,
                               const std::vector<BodyPose>& body_poses,
                               const Rigid3d& body_from_camera) {
  std::vector<LocalPose> poses;
  for (const auto& [image_id, time_ns] : image_times_ns) {
    const std::optional<Rigid3d> local_from_body = At(body_poses, time_ns);
    if (!local_from_body) continue;
    poses.push_back({image_id, *local_from_body * body_from_camera, time_ns / kNsPerUs});
  }
  return poses;
}

}  // namespace

void ReadEurocImages(const SideFile& file, SideData& data) {
  for (const CsvLine& row : RowsOf(file)) {
    if (row.cells.size() != 2) {
      throw InvalidSideFile(file, row.number, "must be timestamp,filename");
    }
    const std::string image_id = IdFromFileName(WordsOf(row.cells[1]).empty() ? "" : row.cells[1]);
    data.image_times_ns[image_id] = TimeOf(row.cells[0], file, row.number);
  }
}

// timestamp, p_RS_R [m], q_RS (w first): R is level, S the body.
void ReadEurocGroundTruth(const SideFile& file, SideData& data) {
  for (const CsvLine& row : RowsOf(file)) {
    if (row.cells.size() < kNumPoseCells) {
      throw InvalidSideFile(file, row.number, "must be timestamp, position, quaternion");
    }
    const int64_t time_ns = TimeOf(row.cells[0], file, row.number);
    const std::vector<double> n = NumbersOf(row.cells, 1, kNumPoseCells, file, row.number);
    const Eigen::Vector3d position(n[0], n[1], n[2]);
    const int line = row.number;
    data.body_poses.push_back(
        {time_ns, {QuaternionOf(n[3], n[4], n[5], n[6], file, line), position}});
    data.body_poses_w_last.push_back(
        {time_ns, {QuaternionOf(n[6], n[3], n[4], n[5], file, line), position}});
  }
}

void JoinBodyPoses(const SideContext& context, SideData& data) {
  if (data.image_times_ns.empty()) {
    for (const auto& [image_id, tags] : context.image_tags) {
      if (const auto time_ns = TimeOfName(image_id)) data.image_times_ns[image_id] = *time_ns;
    }
  }
  const auto is_earlier = [](const BodyPose& a, const BodyPose& b) {
    return a.timestamp_ns < b.timestamp_ns;
  };
  std::stable_sort(data.body_poses.begin(), data.body_poses.end(), is_earlier);
  std::stable_sort(data.body_poses_w_last.begin(), data.body_poses_w_last.end(), is_earlier);
  if (!data.body_from_camera) {
    throw ApiError("InvalidPoses",
                   "a body's poses need the camera's mounting: T_BS (sensor.yaml) or T_cam_imu "
                   "(camchain) is needed",
                   {{"/poses", "T_BS or T_cam_imu is needed"}});
  }
  data.local_kind = LocalFrameKind::kLevelMetric;
  data.local_poses = PosesAt(data.image_times_ns, data.body_poses, *data.body_from_camera);
  data.local_poses_w_last =
      PosesAt(data.image_times_ns, data.body_poses_w_last, *data.body_from_camera);
  const size_t num_lost = data.image_times_ns.size() - data.local_poses.size();
  if (num_lost > 0) {
    data.file.warnings.push_back("euroc: " + std::to_string(num_lost) +
                                 " images lie outside the time of the poses, or in a gap of it");
  }
}

}  // namespace freelsd
