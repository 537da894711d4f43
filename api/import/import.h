// Bytes -> engine types: images, their tags, pose files, zip archives. Everything here treats its
// input as hostile.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "api/api.h"

namespace freelsd {

struct ImageLimits {
  double max_megapixels = 64.0;
  int max_side_px = 16384;
  size_t max_bytes = 32u << 20;
};

struct ImageHeader {
  bool is_jpeg = false;
  int width_px = 0;
  int height_px = 0;
};

// From the first bytes alone, before any allocation. ApiError UnsupportedImage (415) unless JPEG or
// PNG by magic bytes, DamagedImage (422) when the header is broken, ImageTooLarge (413).
ImageHeader SniffImage(std::string_view bytes, const ImageLimits& limits);

// Strict: a JPEG that makes the decoder warn (truncated, damaged) is ApiError DamagedImage. EXIF
// orientation is ignored: intrinsics belong to the sensor. BGR, 8 bit. A fresh turbojpeg handle
// each time: one spoilt by an error refuses good photographs.
cv::Mat DecodeImage(std::string_view bytes, const ImageLimits& limits);

// What the image says of itself: EXIF GPS, XMP of DJI (gimbal angles), senseFly/Parrot and
// autopilot yaw/pitch/roll, intrinsics from XMP-Camera or EXIF focal length.
struct ImageTags {
  FrameMeta meta;
  std::optional<Camera> camera;
  std::vector<std::string> warnings;
};
// Never throws for odd tags: what is not understood is absent. Safe from several threads.
ImageTags ReadImageTags(std::string_view bytes, const ImageHeader& header);

// Poses of many images: CSV by its header row, or NDJSON of meta objects with an "image" key.
struct PoseFile {
  // Frame id (IdFromFileName of the image column) and what the line says, in file order.
  std::vector<std::pair<std::string, FrameMeta>> poses;
  std::vector<std::string> warnings;  // ignored columns, and what was assumed
  struct Format {
    std::string name;  // "csv", "odm-geo", ...
    std::string path;
    std::string why;
  };
  std::vector<Format> formats;
  std::optional<Camera> camera;
};
// ApiError with pointers "/poses/<line>/<column>" to every line that cannot be used, the first 20.
PoseFile ParsePoses(std::string_view text);

// A text beside the images: poses, a calibration, a reconstruction.
struct SideFile {
  std::string path;  // as in the archive
  std::string text;
};
// By its extension: csv, txt, json, jsonl, ndjson, yaml, yml.
bool IsSideFile(std::string_view path);
// What is known besides.
struct SideContext {
  // The flight's.
  std::optional<GeoPoint> origin;
  // What the images' own tags say, by frame id, in the order of the images.
  std::vector<std::pair<std::string, FrameMeta>> image_tags;
};
// The one door for what comes beside images. Each file's format is found by its content: CSV,
// NDJSON, ODM geo.txt, EuRoC/ASL, Kalibr camchain, ROS camera_info, COLMAP text, OpenSfM. Throws
// ApiError InvalidPoses where a file cannot be used; an empty one is warned of, unless it is all.
PoseFile PosesFromFiles(const std::vector<SideFile>& files, const SideContext& context);

// Entries of a zip, in order, by callback (path in the archive, bytes). Names, kinds and count are
// checked before the first call: two images of one frame id are refused. ApiError ZipRefused (422),
// over a limit ZipTooLarge (413). Folders and what file managers leave behind (__MACOSX, .DS_Store)
// are passed over; FileKind::kUnread comes without its bytes. Reads from a file.
struct ZipLimits {
  int max_entries = 20000;
  double max_ratio = 200.0;
  uint64_t max_total_bytes = uint64_t{16} << 30;
  uint64_t max_entry_bytes = uint64_t{64} << 20;
};
void ReadZip(const std::string& path,
             const ZipLimits& limits,
             const std::function<void(const std::string& path, std::string&& bytes)>& entry);

// "[A-Za-z0-9._-]{1,128}", not "." or "..".
bool IsValidId(std::string_view id);
// A file name's other characters become "_"; folders are cut off.
std::string IdFromFileName(std::string_view file_name);
// Lower-case hex.
std::string Sha256Hex(std::string_view bytes);

// --- What the files of a batch are, before any of them is read ---

// By the extension.
enum class FileKind {
  kImage,     // jpg, jpeg, png
  kSideFile,  // csv, txt, json, jsonl, ndjson, yaml, yml
  kUnread,    // orthophotos, point clouds, films: tif, laz, mp4, ...
  kUnknown,   // its first bytes decide
};
FileKind KindByName(std::string_view path);
// JPEG or PNG.
bool BeginsAsImage(std::string_view bytes);

// What PosesFromFiles takes each file for, also where it throws.
std::vector<PoseFile::Format> FormatsOf(const std::vector<SideFile>& files);
// Of a .txt: no format is told by its content, and no column of it is known. A README, a log.
bool IsAnyText(const SideFile& file);

// Harmless to print.
std::string ShownPath(const std::string& path);

}  // namespace freelsd
