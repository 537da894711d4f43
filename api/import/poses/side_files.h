// Private to poses/. Shared by the readers of files beside the images.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/import/import.h"
#include "api/import/poses/poses.h"

namespace freelsd {

// Pose of a camera in the local frame of a reconstruction.
struct LocalPose {
  std::string image_id;
  Rigid3d local_from_camera;
};

// A calibration, or why it cannot be used.
struct SideCamera {
  // As the photographs name it; empty if they do not.
  std::string id;
  std::string path;
  Camera camera;
  std::optional<ApiError> problem;
};

// Data read so far from all files.
struct SideData {
  PoseFile file;
  std::vector<LocalPose> local_poses;
  // The same poses, with each quaternion read in the order x, y, z, w.
  std::vector<LocalPose> local_poses_w_last;
  // Where the local frame is east, north, up in metres. Nothing: its scale and attitude are
  // arbitrary and must be fitted to the geotags.
  std::optional<GeoPoint> local_origin;
  std::vector<SideCamera> cameras;
  // The camera of each image that a reconstruction names.
  std::map<std::string, std::string> camera_ids;
  // Of the request, and its tags by frame id.
  SideContext context;
  std::map<std::string, FrameMeta> tags;
};

// Makes an ApiError InvalidPoses with the pointer "/poses/<file>/<line>". Line 0 means the whole
// file.
ApiError InvalidSideFile(const SideFile& file, int line, const std::string& detail);
std::string NameWithoutFolders(const std::string& path);

struct TextLine {
  int number = 0;
  std::string text;
};
// Lines without line ends. kSkip leaves out blank lines and lines that begin with #.
enum class BlankLines { kSkip, kKeep };
std::vector<TextLine> LinesOf(std::string_view text, BlankLines blanks = BlankLines::kSkip);
std::vector<std::string> WordsOf(std::string_view line);
// Numbers in words [first, last). Throws InvalidSideFile if one of them is no finite number.
std::vector<double> NumbersOf(const std::vector<std::string>& words,
                              size_t first,
                              size_t last,
                              const SideFile& file,
                              int line);
// Throws InvalidSideFile if the norm is not near 1.
Eigen::Quaterniond QuaternionOf(
    double w, double x, double y, double z, const SideFile& file, int line);
// Adds the camera that `read` returns, or the ApiError that it throws.
void AddCamera(const std::string& id,
               const SideFile& file,
               const std::function<Camera()>& read,
               SideData& data);
// Chooses the one camera of the flight: nearly equal ones count as one, those of no photograph not
// at all, and of different ones that of most photographs; the poses of the others are left out.
// Throws ApiError if none can be used, or if nothing tells which photograph is whose.
void ChooseCamera(SideData& data);
// The frame id of a path: with its folders if a photograph of the request has them in its id.
std::string ImageIdOf(std::string_view path, const std::map<std::string, FrameMeta>& tags);

// One reader per format. Each reader adds to `data`.
void ReadDjiMarks(const SideFile& file, SideData& data);
void ReadKalibr(const SideFile& file, SideData& data);
void ReadCameraInfo(const SideFile& file, SideData& data);
void ReadColmapCameras(const SideFile& file, SideData& data);
void ReadColmapImages(const SideFile& file, SideData& data);
void ReadOpenSfm(const SideFile& file, SideData& data);
void ReadOpenSfmCameras(const SideFile& file, SideData& data);
void ReadReferenceLla(const SideFile& file, SideData& data);

// Converts local poses to poses on the earth.
void Georeference(SideData& data);
// Warnings about readable poses that are probably wrong. Each warning starts with its name, for
// example "QuaternionOrder: ".
std::vector<std::string> SuspicionsOf(const PoseFile& file, const SideContext& context);
// True if many cameras do not look down, but nearly all do if the quaternions are read with w last.
bool IsWLastLikely(const std::vector<Eigen::Quaterniond>& ned_from_x,
                   const std::vector<Eigen::Quaterniond>& ned_from_x_w_last);

}  // namespace freelsd
