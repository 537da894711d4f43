// Files beside the images (pose files, calibrations, reconstructions) -> poses and a camera.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/api.h"

namespace freelsd {

// Poses of many images, with the detected formats and a camera.
struct PoseFile {
  // Frame id (IdFromFileName of the image column) and meta of each line, in file order.
  std::vector<std::pair<std::string, FrameMeta>> poses;
  std::vector<std::string> warnings;  // ignored columns and assumptions
  struct Format {
    std::string name;  // "csv", "odm-geo", ...
    std::string path;
    std::string why;
  };
  std::vector<Format> formats;
  std::optional<Camera> camera;
};
// A text file beside the images: poses, a calibration or a reconstruction.
struct SideFile {
  std::string path;  // as in the archive
  std::string text;
};
// Data of the flight and its images that the readers need.
struct SideContext {
  // The flight's origin.
  std::optional<GeoPoint> origin;
  // Meta from the images' own tags, by frame id, in the order of the images.
  std::vector<std::pair<std::string, FrameMeta>> image_tags;
};
// A table of poses as other programs write it, or NDJSON. Lines and values that cannot be used are
// left out with a warning. Throws ApiError InvalidPoses, with up to 20 pointers
// "/poses/<line>/<column>", if no line can be used. The photographs' own tags give altitudes that
// the table lacks, and decide where its columns leave a doubt.
PoseFile ParsePoses(std::string_view text, const SideContext& context = {});

// Reads all files beside the images. The format is detected from the content: tables, NDJSON, DJI's
// MRK, Kalibr camchain, ROS camera_info, COLMAP text, OpenSfM, OpenDroneMap's cameras. Throws
// ApiError InvalidPoses if a file is invalid or all are empty. One empty file among others is a
// warning.
PoseFile PosesFromFiles(const std::vector<SideFile>& files, const SideContext& context);

// The format that PosesFromFiles detects for each file. Works also if PosesFromFiles throws.
std::vector<PoseFile::Format> FormatsOf(const std::vector<SideFile>& files);
// True for a .txt without a known format or column, for example a README or a log.
bool IsAnyText(const SideFile& file);

}  // namespace freelsd
