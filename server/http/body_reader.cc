#include "server/http/body_reader.h"

#include <algorithm>
#include <array>

#include "api/api.h"

namespace freelsd {
namespace {

// A longer rest of a refused body costs more than a new connection.
constexpr uint64_t kMaxSkippedBytes = 256 << 10;
// How long reading that rest may take.
constexpr std::chrono::seconds kSkipTimeout{1};
// Least mean rate of an upload, after the grace time: a slower client would hold a thread for long.
constexpr double kMinBytesPerSecond = 8192.0;
constexpr double kGraceSeconds = 10.0;
constexpr size_t kMaxChunkLine = 64;
constexpr size_t kMaxChunkDigits = 12;
constexpr int kMaxNumTrailerBytes = 4096;

[[noreturn]] void RefuseChunk() {
  throw ApiError("InvalidRequest", "the chunked body is malformed");
}

}  // namespace

BodyReader::BodyReader(const ClientSocket& socket, const RequestHead& head, std::string& buffered)
    : socket_(socket),
      buffered_(buffered),
      is_chunked_(head.is_chunked),
      must_continue_(head.expects_continue && head.HasBody()),
      is_at_end_(!head.HasBody()),
      num_left_(head.content_length.value_or(0)) {}

void BodyReader::LimitTo(uint64_t max_bytes) {
  max_bytes_ = max_bytes;
  const uint64_t known = num_read_ + num_left_;
  if (known > max_bytes_) Count(static_cast<size_t>(known - num_read_));
}

void BodyReader::Count(size_t num_bytes) {
  num_read_ += num_bytes;
  if (num_read_ <= max_bytes_) return;
  ApiError error("BodyTooLarge",
                 "the body is larger than " + std::to_string(max_bytes_) + " bytes");
  error.limit = static_cast<double>(max_bytes_);
  error.observed = static_cast<double>(num_read_);
  throw error;
}

void BodyReader::CheckRate() const {
  if (is_live_) return;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
  const double num_wanted = kMinBytesPerSecond * (elapsed.count() - kGraceSeconds);
  if (static_cast<double>(num_read_) >= num_wanted) return;
  throw ApiError("RequestTimeout", "the body arrives too slowly");
}

size_t BodyReader::ReadRaw(char* bytes, size_t size) {
  if (!buffered_.empty()) {
    const size_t num_taken = std::min(size, buffered_.size());
    buffered_.copy(bytes, num_taken);
    buffered_.erase(0, num_taken);
    return num_taken;
  }
  if (must_continue_) {
    must_continue_ = false;
    socket_.Write("HTTP/1.1 100 Continue\r\n\r\n");
  }
  CheckRate();
  const SteadyTime deadline = std::chrono::steady_clock::now() + idle_timeout_;
  const size_t num_read = socket_.Read(bytes, size, deadline);
  if (num_read > 0) return num_read;
  if (std::chrono::steady_clock::now() >= deadline) {
    throw ApiError("RequestTimeout", "the body did not arrive in time");
  }
  throw ApiError("InvalidRequest", "the body ended early");
}

char BodyReader::ReadByte() {
  // Buffered, because chunk lines are read byte by byte.
  if (buffered_.empty()) {
    std::array<char, 4096> bytes;
    const size_t num_read = ReadRaw(bytes.data(), bytes.size());
    buffered_.assign(bytes.data(), num_read);
  }
  const char byte = buffered_.front();
  buffered_.erase(0, 1);
  return byte;
}

void BodyReader::StartChunk() {
  std::string line;
  while (line.empty() || line.back() != '\n') {
    line.push_back(ReadByte());
    if (line.size() > kMaxChunkLine) RefuseChunk();
  }
  if (line.size() < 3 || line[line.size() - 2] != '\r') RefuseChunk();
  const std::string digits = line.substr(0, line.find_first_of("; \r"));
  const bool is_hexadecimal =
      !digits.empty() && digits.size() <= kMaxChunkDigits &&
      digits.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
  if (!is_hexadecimal) RefuseChunk();
  num_left_ = std::stoull(digits, nullptr, 16);
  if (num_left_ > 0) return;
  // Trailers end with an empty line. Their content is ignored.
  std::string tail = "\r\n";
  for (int i = 0; i < kMaxNumTrailerBytes; ++i) {
    tail.push_back(ReadByte());
    if (tail.ends_with("\r\n\r\n")) {
      is_at_end_ = true;
      return;
    }
  }
  RefuseChunk();
}

void BodyReader::EndChunk() {
  if (ReadByte() != '\r' || ReadByte() != '\n') RefuseChunk();
}

size_t BodyReader::Read(char* bytes, size_t size) {
  if (is_at_end_) return 0;
  if (is_chunked_ && num_left_ == 0) StartChunk();
  if (is_at_end_) return 0;
  const size_t num_read = ReadRaw(bytes, static_cast<size_t>(std::min<uint64_t>(size, num_left_)));
  num_left_ -= num_read;
  Count(num_read);
  if (num_left_ == 0 && is_chunked_) EndChunk();
  if (num_left_ == 0 && !is_chunked_) is_at_end_ = true;
  return num_read;
}

std::string BodyReader::ReadAll(uint64_t max_bytes) {
  LimitTo(max_bytes);
  std::string body;
  std::array<char, 65536> bytes;
  while (const size_t num_read = Read(bytes.data(), bytes.size())) {
    body.append(bytes.data(), num_read);
  }
  return body;
}

bool BodyReader::SkipRest() {
  if (is_at_end_) return true;
  // A client that waits for "100 Continue" sends no body after a final answer.
  if (must_continue_ || (!is_chunked_ && num_left_ > kMaxSkippedBytes)) return false;
  max_bytes_ = num_read_ + kMaxSkippedBytes;
  idle_timeout_ = kSkipTimeout;
  const SteadyTime deadline = std::chrono::steady_clock::now() + kSkipTimeout;
  try {
    std::array<char, 65536> ignored;
    while (Read(ignored.data(), ignored.size()) > 0) {
      if (std::chrono::steady_clock::now() > deadline) return false;
    }
  } catch (const ApiError&) {
    // The rest is too long or broken.
    return false;
  }
  return true;
}

}  // namespace freelsd
