// Reads a batch as it arrives: checks and writes each image and parses the poses. Inserts no rows
// into the database.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "api/import/poses/poses.h"
#include "server/http/http.h"
#include "server/intake/checked_image.h"

namespace freelsd {

// Result of the check of one image of a batch.
struct BatchImage {
  // As in the request.
  std::string path;
  std::string id;
  // Empty if the image was refused. In that case code and reason are set.
  std::optional<CheckedImage> image;
  std::string code;
  std::string reason;
};

// Writes images as they arrive. The destructor removes images that no frame refers to.
class BatchUpload {
 public:
  explicit BatchUpload(Intake& intake) : intake_(intake) {}
  ~BatchUpload();
  BatchUpload(const BatchUpload&) = delete;
  BatchUpload& operator=(const BatchUpload&) = delete;

  // Reads a multipart body with the parts `images` and `poses` (files beside the images), or a zip
  // archive of the same files. Throws ApiError if the body's structure is invalid.
  void Read(const Call& call);
  // Parses the files beside the images. Call it after Read. Sets poses().formats even if it throws
  // ApiError.
  void ParsePoses(const std::optional<GeoPoint>& origin);

  const std::vector<BatchImage>& images() const { return images_; }
  const PoseFile& poses() const { return poses_; }

 private:
  void ReadParts(const Call& call, const std::string& boundary);
  void ReadArchive(const Call& call);
  void AddEntry(const std::string& path, std::string&& bytes);
  void AddImage(const std::string& file_name, const std::optional<std::string>& bytes);
  void AddSideFile(const std::string& path, const std::optional<std::string>& text);
  void NameImages();
  void MatchNames();
  void TellOfOthers();

  Intake& intake_;
  std::vector<BatchImage> images_;
  std::optional<Camera> camera_;
  std::vector<SideFile> side_files_;
  size_t num_side_file_bytes_ = 0;
  // Files of an archive that are neither images nor of a known format.
  std::vector<std::string> others_;
  size_t num_leftovers_ = 0;
  size_t num_copies_ = 0;
  PoseFile poses_;
  std::set<std::string> written_;
};

}  // namespace freelsd
