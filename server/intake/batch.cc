#include "server/intake/batch.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include "api/api.h"
#include "api/import/images/images.h"
#include "api/import/import.h"
#include "api/import/poses/poses.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr char kOtherFile[] = "neither an image (JPEG, PNG) nor a file of a known format";

// A file in the spool folder; the destructor removes it.
class SpoolFile {
 public:
  explicit SpoolFile(const std::filesystem::path& path) : path_(path) {}
  ~SpoolFile() {
    std::error_code error;
    std::filesystem::remove(path_, error);
  }
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  void Fill(BodyReader& body) const {
    std::ofstream file(path_, std::ios::binary);
    std::array<char, 65536> bytes;
    while (const size_t num_read = body.Read(bytes.data(), bytes.size())) {
      file.write(bytes.data(), static_cast<std::streamsize>(num_read));
    }
    file.close();
    if (!file) {
      throw StorageError("write the spool file", "no space or I/O error", StorageFault::kFull);
    }
  }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

std::string Mebibytes(uint64_t num_bytes) { return std::to_string(num_bytes >> 20) + " MiB"; }

}  // namespace

BatchUpload::~BatchUpload() {
  for (const std::string& sha256 : written_) {
    try {
      intake_.storage.images.RemoveUnused(sha256);
    } catch (const StorageError&) {
      // The next start removes the file.
      continue;
    }
  }
}

void BatchUpload::Read(const Call& call) {
  call.body.LimitTo(intake_.config.max_batch_bytes);
  if (const auto flight = intake_.storage.flights.Find(call.Id("flight"))) {
    camera_ = CameraOf(*flight);
  }
  const auto boundary = MultipartBoundary(call.request.get_header_value("Content-Type"));
  if (boundary) {
    ReadParts(call, *boundary);
  } else {
    ReadArchive(call);
  }
  NameImages();
  if (images_.empty() && side_files_.empty()) {
    const std::string detail =
        others_.empty() ? "the batch has no images"
                        : "the batch has no images: " + ShownPath(others_[0]) + " is " + kOtherFile;
    throw ApiError("MissingPart", detail, {{"/images", "is missing"}});
  }
}

void BatchUpload::ReadParts(const Call& call, const std::string& boundary) {
  MultipartReader parts([&call](char* bytes, size_t size) { return call.body.Read(bytes, size); },
                        boundary);
  while (const std::optional<Part> part = parts.Next()) {
    if (part->name == "images" && IsLeftover(part->file_name)) {
      parts.ReadAll(intake_.image_limits.max_bytes);
      ++num_leftovers_;
    } else if (part->name == "images") {
      AddImage(part->file_name, parts.ReadAll(intake_.image_limits.max_bytes));
    } else if (part->name == "poses") {
      AddSideFile(part->file_name, parts.ReadAll(kLimits.poses.max_file_bytes));
    } else {
      throw ApiError("UnknownPart", "a batch accepts only parts named images and poses");
    }
  }
}

void BatchUpload::ReadArchive(const Call& call) {
  const SpoolFile file(intake_.storage.SpoolFolder() / NewId("zip"));
  file.Fill(call.body);
  std::array<char, 4> magic{};
  std::ifstream(file.path(), std::ios::binary).read(magic.data(), magic.size());
  if (magic[0] != 'P' || magic[1] != 'K') {
    throw ApiError("UnsupportedMediaType", "a batch is multipart/form-data or a zip archive");
  }
  num_leftovers_ =
      ReadZip(file.path(), kLimits.zip, [this](const std::string& path, std::string&& bytes) {
        AddEntry(path, std::move(bytes));
      });
}

void BatchUpload::AddEntry(const std::string& path, std::string&& bytes) {
  const FileKind kind = KindByName(path);
  if (kind == FileKind::kImage || (kind == FileKind::kUnknown && BeginsAsImage(bytes))) {
    AddImage(path, std::move(bytes));
  } else if (IsSideFile(path) && !IsAnyText({path, bytes})) {
    AddSideFile(path, std::move(bytes));
  } else {
    others_.push_back(path);
  }
}

void BatchUpload::AddImage(const std::string& file_name, const std::optional<std::string>& bytes) {
  BatchImage entry;
  entry.path = file_name;
  if (images_.size() >= kLimits.batch.max_num_images) {
    throw ApiError(
        "TooManyParts",
        "a batch has at most " + std::to_string(kLimits.batch.max_num_images) + " images");
  }
  try {
    if (!bytes) {
      throw ApiError("ImageTooLarge",
                     "the file is larger than " + Mebibytes(intake_.image_limits.max_bytes));
    }
    entry.image = CheckImage(intake_, *bytes, camera_);
    written_.insert(entry.image->sha256);
    intake_.storage.images.Write(entry.image->sha256, *bytes);
  } catch (const ApiError& error) {
    entry.code = error.code();
    entry.reason = error.what();
  }
  images_.push_back(std::move(entry));
}

// The id is the file's name; where several files share it, their paths make them different. The
// same photograph twice is one.
void BatchUpload::NameImages() {
  std::map<std::string, std::set<std::string>> paths_of;
  std::set<std::pair<std::string, std::string>> contents;
  const auto is_copy = [&](const BatchImage& entry) {
    return entry.image &&
           !contents.insert({IdFromFileName(entry.path), entry.image->sha256}).second;
  };
  const size_t num_images = images_.size();
  std::erase_if(images_, is_copy);
  num_copies_ = num_images - images_.size();
  for (BatchImage& entry : images_) {
    entry.id = IdFromFileName(entry.path);
    paths_of[entry.id].insert(entry.path);
  }
  std::set<std::string> ids;
  for (size_t i = 0; i < images_.size(); ++i) {
    BatchImage& entry = images_[i];
    if (paths_of[entry.id].size() > 1) entry.id = IdFromPath(entry.path);
    if (ids.insert(entry.id).second) continue;
    throw ApiError("DuplicateId",
                   "two files have the id " + entry.id,
                   {{"/images/" + std::to_string(i), "is a duplicate"}});
  }
}

// Programs write names in another case or without the extension.
void BatchUpload::MatchNames() {
  const auto lower = [](std::string text) {
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return text;
  };
  const auto stem = [](const std::string& name) { return name.substr(0, name.rfind('.')); };
  std::map<std::string, std::set<std::string>> ids_of;
  std::set<std::string> taken;
  for (const BatchImage& entry : images_) {
    ids_of[lower(entry.id)].insert(entry.id);
    ids_of[lower(stem(entry.id))].insert(entry.id);
    taken.insert(entry.id);
  }
  const std::set<std::string> known = taken;
  for (const auto& [id, meta] : poses_.poses) taken.erase(id);
  size_t num_matched = 0;
  for (auto& [id, meta] : poses_.poses) {
    if (known.contains(id)) continue;
    const auto found = ids_of.find(lower(id));
    if (found == ids_of.end() || found->second.size() != 1) continue;
    if (taken.erase(*found->second.begin()) == 0) continue;
    id = *found->second.begin();
    ++num_matched;
  }
  if (num_matched == 0) return;
  poses_.warnings.push_back(std::to_string(num_matched) +
                            " poses name their image in another case or without its extension");
}

void BatchUpload::AddSideFile(const std::string& path, const std::optional<std::string>& text) {
  if (!text) {
    throw ApiError("PosesTooLarge",
                   "the pose file is larger than " + Mebibytes(kLimits.poses.max_file_bytes));
  }
  if (side_files_.size() >= kLimits.batch.max_num_side_files) {
    throw ApiError("TooManyParts",
                   "a batch has at most " + std::to_string(kLimits.batch.max_num_side_files) +
                       " files beside its images");
  }
  num_side_file_bytes_ += text->size();
  if (num_side_file_bytes_ > kLimits.batch.max_total_side_file_bytes) {
    throw ApiError("PosesTooLarge",
                   "the files beside the images are together larger than " +
                       Mebibytes(kLimits.batch.max_total_side_file_bytes));
  }
  side_files_.push_back({path, *text});
}

void BatchUpload::ParsePoses(const std::optional<GeoPoint>& origin) {
  SideContext context;
  context.origin = origin;
  for (const BatchImage& entry : images_) {
    if (entry.image) context.image_tags.emplace_back(entry.id, entry.image->tags.meta);
  }
  poses_ = {};
  poses_.formats = FormatsOf(side_files_);
  TellOfOthers();
  PoseFile read = PosesFromFiles(side_files_, context);
  poses_.poses = std::move(read.poses);
  poses_.camera = read.camera;
  poses_.warnings.insert(poses_.warnings.end(), read.warnings.begin(), read.warnings.end());
  MatchNames();
}

void BatchUpload::TellOfOthers() {
  if (num_leftovers_ > 0) {
    poses_.warnings.push_back(std::to_string(num_leftovers_) +
                              " files of file managers and thumbnails are ignored");
  }
  if (num_copies_ > 0) {
    poses_.warnings.push_back(std::to_string(num_copies_) +
                              " photographs came twice: each is used once");
  }
  const size_t num_told = std::min(others_.size(), kLimits.answer.max_num_listed_errors);
  for (size_t i = 0; i < num_told; ++i) {
    const std::string path = ShownPath(others_[i]);
    poses_.formats.push_back({"unknown", path, kOtherFile});
    poses_.warnings.push_back(path + ": " + kOtherFile + ", ignored");
  }
  if (others_.size() > num_told) {
    poses_.warnings.push_back(std::to_string(others_.size() - num_told) +
                              " more files of the archive were ignored");
  }
}

}  // namespace freelsd
