#include <algorithm>
#include <array>

#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"

namespace freelsd {
namespace {

std::string ExtensionOf(std::string_view path) {
  const size_t dot = path.rfind('.');
  std::string extension(dot == std::string_view::npos ? "" : path.substr(dot + 1));
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

struct KnownExtension {
  std::string_view extension;
  FileKind kind;
};
constexpr std::array<KnownExtension, 21> kKnownExtensions{{
    {"jpg", FileKind::kImage},      {"jpeg", FileKind::kImage},   {"png", FileKind::kImage},
    {"csv", FileKind::kSideFile},   {"txt", FileKind::kSideFile}, {"json", FileKind::kSideFile},
    {"jsonl", FileKind::kSideFile}, {"mrk", FileKind::kSideFile}, {"ndjson", FileKind::kSideFile},
    {"yaml", FileKind::kSideFile},  {"yml", FileKind::kSideFile}, {"tif", FileKind::kUnread},
    {"tiff", FileKind::kUnread},    {"las", FileKind::kUnread},   {"laz", FileKind::kUnread},
    {"ply", FileKind::kUnread},     {"obj", FileKind::kUnread},   {"pdf", FileKind::kUnread},
    {"mp4", FileKind::kUnread},     {"mov", FileKind::kUnread},   {"dng", FileKind::kUnread},
}};

}  // namespace

bool IsLeftover(std::string_view path) {
  constexpr std::array<std::string_view, 3> kFiles{".DS_Store", "Thumbs.db", "desktop.ini"};
  constexpr std::array<std::string_view, 6> kFolders{
      "__MACOSX", "@eaDir", ".thumbnails", ".Trashes", "THM", ".Spotlight-V100"};
  while (true) {
    const size_t end = path.find_first_of("/\\");
    const std::string_view part = path.substr(0, end);
    if (end == std::string_view::npos) {
      return part.starts_with("._") ||
             std::find(kFiles.begin(), kFiles.end(), part) != kFiles.end();
    }
    if (std::find(kFolders.begin(), kFolders.end(), part) != kFolders.end()) return true;
    path.remove_prefix(end + 1);
  }
}

bool IsSideFile(std::string_view path) { return KindByName(path) == FileKind::kSideFile; }

FileKind KindByName(std::string_view path) {
  const std::string extension = ExtensionOf(path);
  for (const KnownExtension& known : kKnownExtensions) {
    if (known.extension == extension) return known.kind;
  }
  return FileKind::kUnknown;
}

bool BeginsAsImage(std::string_view bytes) { return IsJpeg(bytes) || IsPng(bytes); }

}  // namespace freelsd
