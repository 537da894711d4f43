#include "server/http/page.h"

#include <fstream>
#include <iterator>

namespace freelsd {
namespace {

std::string ContentType(const std::string& extension) {
  static const std::map<std::string, std::string> kTypes{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
  };
  const auto found = kTypes.find(extension);
  return found == kTypes.end() ? "text/plain; charset=utf-8" : found->second;
}

}  // namespace

Page ReadPage(const std::filesystem::path& folder) {
  Page page;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string path = "/" + std::filesystem::relative(entry.path(), folder).generic_string();
    page[path] = {ContentType(entry.path().extension().string()),
                  std::string(std::istreambuf_iterator<char>(file), {})};
  }
  const auto index = page.find("/index.html");
  if (index != page.end()) page["/"] = index->second;
  const auto docs = page.find("/docs.html");
  if (docs != page.end()) page["/docs"] = docs->second;
  return page;
}

std::filesystem::path BesideProgram(const std::string& name) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / "../share/freelsd" / name).lexically_normal();
}

}  // namespace freelsd
