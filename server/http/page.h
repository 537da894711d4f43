// The files of the ground-station page. They are read once at start, so that no request opens a
// file.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace freelsd {

// A file of the page, in memory.
struct PageFile {
  std::string content_type;
  std::string content;
};

// By URL path ("/", "/docs", "/app.js", "/vendor/leaflet.js").
using Page = std::map<std::string, PageFile>;
// Empty if the folder does not exist.
Page ReadPage(const std::filesystem::path& folder);

// Path of a file or folder that is installed with the program: ../share/freelsd/`name`, relative to
// the program's folder.
std::filesystem::path BesideProgram(const std::string& name);

}  // namespace freelsd
