// multipart bodies, part by part, without holding more than a window of it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

struct Part {
  std::string name;
  std::string file_name;
  // Empty where the part does not say.
  std::string content_type;
  // X-Timestamp-Us, as it stands.
  std::string timestamp_us;
};

// Boundary of a Content-Type; nothing when it is not of this kind of multipart. Throws ApiError
// InvalidMultipart when it is and has no usable boundary.
std::optional<std::string> MultipartBoundary(const std::string& content_type,
                                             const std::string& kind = "multipart/form-data");

class MultipartReader {
 public:
  // Up to `size` bytes of the body; 0 at its end.
  using Source = std::function<size_t(char* bytes, size_t size)>;
  MultipartReader(Source source, const std::string& boundary);

  // The next part, after what is left of the current one; nothing after the last. Throws ApiError
  // InvalidMultipart where the body is malformed or ends early.
  std::optional<Part> Next();
  // The current part's content. Nothing when it is larger than max_bytes; the rest is skipped.
  std::optional<std::string> ReadAll(size_t max_bytes);

 private:
  bool Fill();
  // Content up to the delimiter, piece by piece; nothing when the delimiter is reached.
  std::optional<std::string> ReadPiece();
  std::string ReadLine();

  Source source_;
  // CR LF "--" boundary; the window starts with CR LF so that the first one matches too.
  std::string delimiter_;
  std::string window_ = "\r\n";
  bool is_in_part_ = true;
  bool is_at_end_ = false;
};

}  // namespace freelsd
