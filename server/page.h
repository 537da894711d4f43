// The ground-station page's files, read once at start: no request ever opens a path.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace freelsd {

struct PageFile {
  std::string content_type;
  std::string content;
};

// By URL path ("/", "/docs", "/app.js", "/vendor/leaflet.js"). Empty when the folder is not there.
using Page = std::map<std::string, PageFile>;
Page ReadPage(const std::filesystem::path& folder);

// The first of the places that exists, else an empty path. Relative places are seen from the
// running program's folder.
std::filesystem::path FirstExisting(const std::vector<std::filesystem::path>& places);

}  // namespace freelsd
