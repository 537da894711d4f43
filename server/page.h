// The ground-station page's files, read once at start: no request ever opens a path.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace freelsd {

struct PageFile {
  std::string content_type;
  std::string content;
};

// By URL path ("/", "/docs", "/app.js", "/vendor/leaflet.js"). Empty when the folder is not there.
using Page = std::map<std::string, PageFile>;
Page ReadPage(const std::filesystem::path& folder);

// What is built and installed with the program: in ../share/freelsd, seen from its folder.
std::filesystem::path BesideProgram(const std::string& name);

}  // namespace freelsd
