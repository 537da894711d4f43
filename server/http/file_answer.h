// Answers with a file of any size.
#pragma once

#include <filesystem>
#include <string>

#include "server/http/http_library.h"

namespace freelsd {

// A file that is removed at the end. Its folder is SpoolFolder.
class SpooledFile {
 public:
  explicit SpooledFile(const std::filesystem::path& folder);
  ~SpooledFile();
  SpooledFile(const SpooledFile&) = delete;
  SpooledFile& operator=(const SpooledFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Sends the bytes that the file has now; it may be removed after this call. Uses memory for a small
// part of it. Call it only while serving a request. Throws std::runtime_error if the file cannot be
// read.
void AnswerFile(httplib::Response& response,
                const std::string& content_type,
                const std::filesystem::path& file);

}  // namespace freelsd
