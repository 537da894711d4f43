// Private to import/. What the readers of the files beside the images have in common.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/import/import.h"

namespace freelsd {

// A camera in the frame of a reconstruction or of a laboratory.
struct LocalPose {
  std::string image_id;
  Rigid3d local_from_camera;
  std::optional<int64_t> timestamp_us;
};

// How a local frame lies on the earth.
enum class LocalFrameKind {
  kAnySimilarity,  // scale and attitude are arbitrary: geotags decide
  kLevelMetric,    // metres, z up; which way x points is not said
  kEastNorthUp,    // about `local_origin`
};

struct BodyPose {
  int64_t timestamp_ns = 0;
  Rigid3d local_from_body;
};

// What was read so far, file by file.
struct SideData {
  PoseFile file;
  std::vector<LocalPose> local_poses;
  // The same file, had it the quaternions' w last.
  std::vector<LocalPose> local_poses_w_last;
  LocalFrameKind local_kind = LocalFrameKind::kAnySimilarity;
  std::optional<GeoPoint> local_origin;
  // EuRoC: joined when all files are read.
  std::vector<BodyPose> body_poses;
  std::vector<BodyPose> body_poses_w_last;
  std::map<std::string, int64_t> image_times_ns;
  std::optional<Rigid3d> body_from_camera;
};

// ApiError InvalidPoses at "/poses/<file>/<line>"; line 0: of the whole file.
ApiError InvalidSideFile(const SideFile& file, int line, const std::string& detail);
std::string NameWithoutFolders(const std::string& path);

struct TextLine {
  int number = 0;
  std::string text;
};
// Without line ends; blank ones and those that begin with # only where asked for.
enum class BlankLines { kSkip, kKeep };
std::vector<TextLine> LinesOf(std::string_view text, BlankLines blanks = BlankLines::kSkip);
std::vector<std::string> WordsOf(std::string_view line);
// Throws InvalidSideFile unless all words from `first` to before `last` are finite numbers.
std::vector<double> NumbersOf(const std::vector<std::string>& words,
                              size_t first,
                              size_t last,
                              const SideFile& file,
                              int line);
// Throws InvalidSideFile where the norm is not near 1.
Eigen::Quaterniond QuaternionOf(
    double w, double x, double y, double z, const SideFile& file, int line);
// Throws InvalidSideFile where Camera::Check refuses, or another camera was read before.
void SetCamera(const Camera& camera, const SideFile& file, SideData& data);

// One reader per format. Each adds to `data`.
void ReadOdmGeo(const SideFile& file, SideData& data);
void ReadKalibr(const SideFile& file, SideData& data);
void ReadCameraInfo(const SideFile& file, SideData& data);
void ReadEurocSensor(const SideFile& file, SideData& data);
void ReadEurocImages(const SideFile& file, SideData& data);
void ReadEurocGroundTruth(const SideFile& file, SideData& data);
void ReadColmapCameras(const SideFile& file, SideData& data);
void ReadColmapImages(const SideFile& file, SideData& data);
void ReadOpenSfm(const SideFile& file, SideData& data);
void ReadReferenceLla(const SideFile& file, SideData& data);

// EuRoC: poses of the images from those of the body before and after.
void JoinBodyPoses(const SideContext& context, SideData& data);
// Local poses -> poses on the earth.
void Georeference(const SideContext& context, SideData& data);
// Warnings by name of what looks wrong though it can be read.
std::vector<std::string> SuspicionsOf(const PoseFile& file, const SideContext& context);
// Whether reading the quaternions w last makes cameras look down that do not as they stand.
bool IsWLastLikely(const std::vector<Eigen::Quaterniond>& ned_from_x,
                   const std::vector<Eigen::Quaterniond>& ned_from_x_w_last);

}  // namespace freelsd
