// Reads multipart bodies part by part, with only a small window of the body in memory.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

// The headers of one part.
struct Part {
  std::string name;
  std::string file_name;
  // Empty if the part has no Content-Type.
  std::string content_type;
  // Value of the header X-Timestamp-Us, not parsed.
  std::string timestamp_us;
};

// The boundary in a Content-Type; nothing if the Content-Type is not `kind`. Throws ApiError
// InvalidMultipart if the type is `kind` but the boundary is missing or invalid.
std::optional<std::string> MultipartBoundary(const std::string& content_type,
                                             const std::string& kind = "multipart/form-data");

// Not thread-safe.
class MultipartReader {
 public:
  // Reads up to `size` bytes of the body; returns 0 at its end.
  using Source = std::function<size_t(char* bytes, size_t size)>;
  MultipartReader(Source source, const std::string& boundary);

  // Skips the rest of the current part and returns the next part; nothing after the last one.
  // Throws ApiError InvalidMultipart if the body is malformed or ends early.
  std::optional<Part> Next();
  // Content of the current part. Nothing if it is larger than max_bytes; it is then skipped.
  std::optional<std::string> ReadAll(size_t max_bytes);

 private:
  bool Fill();
  // The next piece of the content; nothing at the delimiter.
  std::optional<std::string> ReadPiece();
  std::string ReadLine();

  Source source_;
  // CR LF "--", followed by the boundary. `window_` starts with CR LF, so that the first boundary
  // matches too.
  std::string delimiter_;
  std::string window_ = "\r\n";
  bool is_in_part_ = true;
  bool is_at_end_ = false;
};

}  // namespace freelsd
