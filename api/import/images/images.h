// Bytes -> images: headers, pixels, tags, and zip archives of images.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "api/api.h"

namespace freelsd {

struct ImageHeader {
  bool is_jpeg = false;
  int width_px = 0;
  int height_px = 0;
};

// Reads only the header and allocates nothing. Throws ApiError UnsupportedImage (415) if the magic
// bytes are not of JPEG or PNG, DamagedImage (422) if the header is broken, ImageTooLarge (413).
ImageHeader SniffImage(std::string_view bytes, const ImageLimits& limits);

struct DecodedImage {
  cv::Mat pixels;  // BGR, 8 bit
  // What the decoder noticed that changes no pixel.
  std::vector<std::string> warnings;
};
// Throws ApiError DamagedImage if pixels are missing or damaged; it tells how many rows. EXIF
// orientation is ignored because intrinsics belong to the sensor.
DecodedImage DecodeAndTell(std::string_view bytes, const ImageLimits& limits);
cv::Mat DecodeImage(std::string_view bytes, const ImageLimits& limits);

// Data in an image's tags: EXIF GPS; attitude from the XMP of DJI (gimbal), senseFly, Parrot and
// autopilots; intrinsics from XMP-Camera or from the EXIF focal length.
struct ImageTags {
  FrameMeta meta;
  std::optional<Camera> camera;
  // Make and model, as in EXIF.
  std::string camera_name;
  // Why a geotag is not used; empty if there is none.
  std::string why_no_position;
  // Why the tags describe no camera; empty if they do.
  std::string why_no_camera;
  std::vector<std::string> warnings;
};
// Malformed tags count as absent and cause no exception. Several threads may call this function at
// once.
ImageTags ReadImageTags(std::string_view bytes, const ImageHeader& header);

// --- Kinds of files in a batch, before their content is read ---

// Kind of a file by its extension.
enum class FileKind {
  kImage,     // jpg, jpeg, png
  kSideFile,  // csv, txt, json, jsonl, mrk, ndjson, yaml, yml
  kUnread,    // orthophotos, point clouds, films: tif, laz, mp4, ...
  kUnknown,   // kind depends on the first bytes
};
FileKind KindByName(std::string_view path);
// True for files that file managers and cameras add: ._*, __MACOSX, .DS_Store, thumbnails.
bool IsLeftover(std::string_view path);
// True if the kind is kSideFile.
bool IsSideFile(std::string_view path);
// True for JPEG and PNG.
bool BeginsAsImage(std::string_view bytes);

// Reads a zip file and calls `entry` for each entry in order (path in the archive in UTF-8, bytes).
// Paths, kinds and count are checked before the first call. Throws ApiError ZipRefused (422) if the
// archive is damaged, encrypted or unsafe, or if two files have the same path; ZipTooLarge (413)
// beyond a limit. Folders and leftovers are skipped; returns the number of leftovers. Entries of
// FileKind::kUnread come without bytes.
size_t ReadZip(const std::string& path,
               const ZipLimits& limits,
               const std::function<void(const std::string& path, std::string&& bytes)>& entry);

}  // namespace freelsd
