#include "server/batch.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "api/api.h"
#include "server/multipart.h"
#include "server/stamps.h"

namespace freelsd {
namespace {

constexpr size_t kMaxPosesBytes = 16 << 20;
constexpr size_t kMaxNumImages = 20000;

// A file in the spool, removed at the end.
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

bool IsPosesName(const std::string& name) {
  const size_t dot = name.rfind('.');
  std::string extension = dot == std::string::npos ? "" : name.substr(dot);
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension == ".csv" || extension == ".ndjson" || extension == ".jsonl" ||
         extension == ".txt";
}

}  // namespace

BatchUpload::~BatchUpload() {
  for (const std::string& sha256 : written_) {
    try {
      service_.storage.RemoveUnusedImage(sha256);
    } catch (const StorageError&) {
      // The file is removed at the next start.
      continue;
    }
  }
}

void BatchUpload::Read(const Call& call) {
  call.body.LimitTo(service_.config.max_batch_bytes);
  const auto boundary = MultipartBoundary(call.request.get_header_value("Content-Type"));
  if (boundary) {
    ReadParts(call, *boundary);
  } else {
    ReadArchive(call);
  }
  if (images_.empty() && !has_poses_) {
    throw ApiError("MissingPart", "the batch has no images", {{"/images", "is missing"}});
  }
}

void BatchUpload::ReadParts(const Call& call, const std::string& boundary) {
  MultipartReader parts([&call](char* bytes, size_t size) { return call.body.Read(bytes, size); },
                        boundary);
  while (const std::optional<Part> part = parts.Next()) {
    if (part->name == "images") {
      AddImage(part->file_name, parts.ReadAll(service_.image_limits.max_bytes));
    } else if (part->name == "poses") {
      AddPoses(parts.ReadAll(kMaxPosesBytes));
    } else {
      throw ApiError("UnknownPart", "a batch has images and one poses part only");
    }
  }
}

void BatchUpload::ReadArchive(const Call& call) {
  const SpoolFile file(service_.storage.SpoolFolder() / NewId("zip"));
  file.Fill(call.body);
  std::array<char, 4> magic{};
  std::ifstream(file.path(), std::ios::binary).read(magic.data(), magic.size());
  if (magic[0] != 'P' || magic[1] != 'K') {
    throw ApiError("UnsupportedMediaType", "a batch is multipart/form-data or a zip archive");
  }
  ReadZip(file.path(), ZipLimits{}, [this](const std::string& name, std::string&& bytes) {
    if (IsPosesName(name)) {
      AddPoses(std::move(bytes));
    } else {
      AddImage(name, std::move(bytes));
    }
  });
}

void BatchUpload::AddImage(const std::string& file_name, const std::optional<std::string>& bytes) {
  BatchImage entry;
  entry.id = IdFromFileName(file_name);
  const std::string pointer = "/images/" + std::to_string(images_.size());
  if (!IsValidId(entry.id)) {
    throw ApiError("InvalidId", "an image has no usable file name", {{pointer, "file name"}});
  }
  if (!ids_.insert(entry.id).second) {
    throw ApiError(
        "DuplicateId", "two files have the id " + entry.id, {{pointer, "is there twice"}});
  }
  if (images_.size() >= kMaxNumImages) throw ApiError("TooManyParts", "too many images");
  try {
    if (!bytes) throw ApiError("ImageTooLarge", "the file is larger than 32 MiB");
    entry.image = CheckImage(service_, *bytes);
    written_.insert(entry.image->sha256);
    service_.storage.WriteImage(entry.image->sha256, *bytes);
  } catch (const ApiError& error) {
    entry.code = error.code();
    entry.reason = error.what();
  }
  images_.push_back(std::move(entry));
}

void BatchUpload::AddPoses(const std::optional<std::string>& text) {
  if (has_poses_) throw ApiError("UnknownPart", "a batch has at most one poses part");
  if (!text) throw ApiError("PosesTooLarge", "the pose file is larger than 16 MiB");
  poses_ = ParsePoses(*text);
  has_poses_ = true;
}

}  // namespace freelsd
