// What the files of a batch are, before any of them is read.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/import/import.h"

namespace freelsd {

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
