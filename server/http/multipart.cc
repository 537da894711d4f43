#include "server/http/multipart.h"

#include <algorithm>
#include <array>

#include "api/api.h"
#include "server/http/lower_case.h"

namespace freelsd {
namespace {

constexpr size_t kMaxBoundaryBytes = 70;  // RFC 2046
constexpr size_t kMaxPartLineBytes = 4096;
constexpr int kMaxNumPartLines = 16;
constexpr size_t kFillBytes = 65536;

[[noreturn]] void RefuseForm(const std::string& detail) {
  throw ApiError("InvalidMultipart", detail);
}

// Value of `; key="value"` or `; key=value`. A backslash escapes a quote, as in browsers and curl.
std::optional<std::string> Parameter(const std::string& header, const std::string& key) {
  const std::string lower = LowerCase(header);
  for (size_t at = lower.find(key + "="); at != std::string::npos;
       at = lower.find(key + "=", at + 1)) {
    if (at == 0 || (lower[at - 1] != ';' && lower[at - 1] != ' ')) continue;
    std::string value;
    size_t i = at + key.size() + 1;
    const bool is_quoted = i < header.size() && header[i] == '"';
    if (is_quoted) ++i;
    for (; i < header.size(); ++i) {
      if (is_quoted ? header[i] == '"' : (header[i] == ';' || header[i] == ' ')) break;
      if (is_quoted && header[i] == '\\' && i + 1 < header.size() && header[i + 1] == '"') ++i;
      value.push_back(header[i]);
    }
    return value;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> MultipartBoundary(const std::string& content_type,
                                             const std::string& kind) {
  if (!LowerCase(content_type).starts_with(kind)) return std::nullopt;
  std::optional<std::string> boundary = Parameter(content_type, "boundary");
  if (!boundary || boundary->empty() || boundary->size() > kMaxBoundaryBytes) {
    RefuseForm("the Content-Type has no usable boundary");
  }
  return boundary;
}

MultipartReader::MultipartReader(Source source, const std::string& boundary)
    : source_(std::move(source)), delimiter_("\r\n--" + boundary) {}

bool MultipartReader::Fill() {
  std::array<char, kFillBytes> bytes;
  const size_t num_read = source_(bytes.data(), bytes.size());
  window_.append(bytes.data(), num_read);
  return num_read > 0;
}

std::optional<std::string> MultipartReader::ReadPiece() {
  while (is_in_part_) {
    const size_t at = window_.find(delimiter_);
    if (at == 0) {
      window_.erase(0, delimiter_.size());
      is_in_part_ = false;
      return std::nullopt;
    }
    // The end of the window may be the beginning of a delimiter.
    const size_t num_sure =
        at != std::string::npos ? at : window_.size() - std::min(window_.size(), delimiter_.size());
    if (num_sure > 0) {
      std::string piece = window_.substr(0, num_sure);
      window_.erase(0, num_sure);
      return piece;
    }
    if (!Fill()) RefuseForm("the body ends within a part");
  }
  return std::nullopt;
}

std::string MultipartReader::ReadLine() {
  size_t end = 0;
  while ((end = window_.find("\r\n")) == std::string::npos) {
    if (window_.size() > kMaxPartLineBytes) RefuseForm("a part's header line is too long");
    if (!Fill()) RefuseForm("the body ends within a part's header");
  }
  std::string line = window_.substr(0, end);
  window_.erase(0, end + 2);
  return line;
}

std::optional<Part> MultipartReader::Next() {
  while (ReadPiece()) {
  }
  if (is_at_end_) return std::nullopt;
  while (window_.size() < 2) {
    if (!Fill()) RefuseForm("the body ends without its last boundary");
  }
  if (window_.starts_with("--")) {
    is_at_end_ = true;
    window_.clear();
    // Bytes after the last boundary are ignored (RFC 2046).
    while (Fill()) window_.clear();
    return std::nullopt;
  }
  if (!ReadLine().empty()) RefuseForm("a boundary is followed by other characters");
  Part part;
  for (int i = 0; i < kMaxNumPartLines; ++i) {
    const std::string line = ReadLine();
    if (line.empty()) {
      is_in_part_ = true;
      return part;
    }
    const size_t colon = std::min(line.find(':'), line.size());
    const std::string key = LowerCase(line.substr(0, colon));
    const size_t begin = std::min(line.find_first_not_of(" :\t", colon), line.size());
    if (key == "content-type") part.content_type = LowerCase(line.substr(begin));
    if (key == "x-timestamp-us") part.timestamp_us = line.substr(begin);
    if (key != "content-disposition") continue;
    part.name = Parameter(line, "name").value_or("");
    part.file_name = Parameter(line, "filename").value_or("");
  }
  RefuseForm("a part has too many header lines");
}

std::optional<std::string> MultipartReader::ReadAll(size_t max_bytes) {
  std::string content;
  bool is_too_large = false;
  while (const std::optional<std::string> piece = ReadPiece()) {
    is_too_large |= content.size() + piece->size() > max_bytes;
    if (!is_too_large) content += *piece;
  }
  if (is_too_large) return std::nullopt;
  return content;
}

}  // namespace freelsd
