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

// BGR, 8 bit. Strict: if the decoder warns (truncated, damaged), ApiError DamagedImage is thrown.
// EXIF orientation is ignored because intrinsics belong to the sensor. Each call makes a new
// turbojpeg handle because a handle refuses good photographs after an error.
cv::Mat DecodeImage(std::string_view bytes, const ImageLimits& limits);

// Data in an image's tags: EXIF GPS; attitude from the XMP of DJI (gimbal), senseFly, Parrot and
// autopilots; intrinsics from XMP-Camera or from the EXIF focal length.
struct ImageTags {
  FrameMeta meta;
  std::optional<Camera> camera;
  std::vector<std::string> warnings;
};
// Malformed tags count as absent and cause no exception. Several threads may call this function at
// once.
ImageTags ReadImageTags(std::string_view bytes, const ImageHeader& header);

// --- Kinds of files in a batch, before their content is read ---

// Kind of a file by its extension.
enum class FileKind {
  kImage,     // jpg, jpeg, png
  kSideFile,  // csv, txt, json, jsonl, ndjson, yaml, yml
  kUnread,    // orthophotos, point clouds, films: tif, laz, mp4, ...
  kUnknown,   // kind depends on the first bytes
};
FileKind KindByName(std::string_view path);
// True if the kind is kSideFile.
bool IsSideFile(std::string_view path);
// True for JPEG and PNG.
bool BeginsAsImage(std::string_view bytes);

// Reads a zip file and calls `entry` for each entry in order (path in the archive, bytes). Names,
// kinds and count are checked before the first call. Throws ApiError ZipRefused (422) if the
// archive is damaged, encrypted or unsafe, or if two images have the same frame id; ZipTooLarge
// (413) beyond a limit. Folders and files of file managers (__MACOSX, .DS_Store) are skipped.
// Entries of FileKind::kUnread come without bytes.
void ReadZip(const std::string& path,
             const ZipLimits& limits,
             const std::function<void(const std::string& path, std::string&& bytes)>& entry);

}  // namespace freelsd
