#include "server/http/connections/request_reader.h"

#include <algorithm>

namespace freelsd {
namespace {

constexpr size_t kMaxChunkLine = 64;
constexpr size_t kMaxChunkDigits = 12;

[[noreturn]] void RefuseChunk() {
  throw ApiError("InvalidRequest", "the chunked body is malformed");
}

size_t ChunkSize(std::string_view line) {
  const std::string digits(line.substr(0, line.find_first_of("; ")));
  const bool is_hexadecimal =
      !digits.empty() && digits.size() <= kMaxChunkDigits &&
      digits.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
  if (!is_hexadecimal) RefuseChunk();
  return std::stoull(digits, nullptr, 16);
}

[[noreturn]] void RefuseBody(size_t limit, uint64_t observed) {
  ApiError error("BodyTooLarge", "the body is larger than " + std::to_string(limit) + " bytes");
  error.limit = static_cast<double>(limit);
  error.observed = static_cast<double>(observed);
  throw error;
}

[[noreturn]] void RefuseHead(const HeadLimits& limits) {
  throw ApiError("HeadersTooLarge",
                 "the head is larger than " + std::to_string(limits.max_bytes) + " bytes");
}

}  // namespace

bool ChunkScanner::IsWhole(std::string_view bytes) {
  while (!is_in_trailer_) {
    const size_t end = bytes.find("\r\n", position_);
    const size_t line_size = std::min(end, bytes.size()) - position_;
    if (line_size > kMaxChunkLine) RefuseChunk();
    if (end == std::string_view::npos) return false;
    const size_t size = ChunkSize(bytes.substr(position_, line_size));
    is_in_trailer_ = size == 0;
    const size_t next = end + 2 + size + 2;
    if (!is_in_trailer_ && bytes.size() < next) return false;
    // The trailer ends with an empty line, which may follow the last chunk's line at once.
    position_ = is_in_trailer_ ? end : next;
  }
  return bytes.find("\r\n\r\n", position_) != std::string_view::npos;
}

bool RequestReader::FindHead(std::string& buffered) {
  // Blank lines before a request are allowed (RFC 9112, 2.2).
  size_t num_blank = 0;
  while (std::string_view(buffered).substr(num_blank).starts_with("\r\n")) num_blank += 2;
  buffered.erase(0, num_blank);
  constexpr size_t kEndSize = 4;
  const size_t end =
      buffered.find("\r\n\r\n", num_searched_ < kEndSize ? 0 : num_searched_ - kEndSize);
  num_searched_ = buffered.size();
  if (end == std::string::npos) {
    if (buffered.size() <= rules_.head.max_bytes) return false;
    if (buffered.find("\r\n") != std::string::npos) RefuseHead(rules_.head);
    throw ApiError("UriTooLong", "the request line does not end");
  }
  const size_t size = end + kEndSize;
  if (size > rules_.head.max_bytes) RefuseHead(rules_.head);
  head_ = ParseRequestHead(
      std::string_view(buffered).substr(0, size), rules_.head, rules_.allowed_hosts);
  buffered.erase(0, size);
  return true;
}

RequestReader::State RequestReader::StateOfChunks(const std::string& buffered) {
  if (rules_.takes_large_bodies) return State::kLargeBody;
  if (chunks_.IsWhole(buffered)) return State::kWhole;
  if (buffered.size() > rules_.max_small_body_bytes) {
    RefuseBody(rules_.max_small_body_bytes, buffered.size());
  }
  return State::kBody;
}

RequestReader::State RequestReader::StateOfBody(const std::string& buffered) {
  if (head_->is_chunked) return StateOfChunks(buffered);
  const uint64_t length = head_->content_length.value_or(0);
  if (length > rules_.max_small_body_bytes) {
    if (!rules_.takes_large_bodies) RefuseBody(rules_.max_small_body_bytes, length);
    return State::kLargeBody;
  }
  return buffered.size() >= length ? State::kWhole : State::kBody;
}

RequestReader::State RequestReader::Advance(std::string& buffered) {
  if (!head_ && !FindHead(buffered)) return buffered.empty() ? State::kNothing : State::kHead;
  return StateOfBody(buffered);
}

bool RequestReader::MustContinue() {
  const bool must_continue = head_->expects_continue;
  head_->expects_continue = false;
  return must_continue;
}

void RequestReader::Reset() {
  head_.reset();
  chunks_ = {};
  num_searched_ = 0;
}

}  // namespace freelsd
