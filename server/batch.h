// A batch as it arrives: images are checked and written one by one, poses kept, nothing inserted.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/call.h"
#include "server/intake.h"

namespace freelsd {

struct BatchImage {
  std::string id;
  // Nothing where the image was refused: then code and reason say why.
  std::optional<CheckedImage> image;
  std::string code;
  std::string reason;
};

// Writes images as they come; at the end takes back those that no frame came to need.
class BatchUpload {
 public:
  explicit BatchUpload(Service& service) : service_(service) {}
  ~BatchUpload();
  BatchUpload(const BatchUpload&) = delete;
  BatchUpload& operator=(const BatchUpload&) = delete;

  // Multipart of `images` and `poses` (files beside the images), or a zip of the same. Throws
  // ApiError for a fault of structure.
  void Read(const Call& call);
  // After Read: what the files beside the images say. Throws ApiError; what each of them was taken
  // for is known all the same.
  void ParsePoses(const std::optional<GeoPoint>& origin);

  const std::vector<BatchImage>& images() const { return images_; }
  const PoseFile& poses() const { return poses_; }

 private:
  void ReadParts(const Call& call, const std::string& boundary);
  void ReadArchive(const Call& call);
  void AddEntry(const std::string& path, std::string&& bytes);
  void AddImage(const std::string& file_name, const std::optional<std::string>& bytes);
  void AddSideFile(const std::string& path, const std::optional<std::string>& text);
  void TellOfOthers();

  Service& service_;
  std::vector<BatchImage> images_;
  std::optional<Camera> camera_;
  std::set<std::string> ids_;
  std::vector<SideFile> side_files_;
  // Of an archive: neither images nor files that anything here reads.
  std::vector<std::string> others_;
  PoseFile poses_;
  std::set<std::string> written_;
};

}  // namespace freelsd
