// Reads the body of one request, by Content-Length or chunked, up to a limit and only as far as the
// handler asks. Only the thread that serves the request uses it.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/http/client_socket.h"
#include "server/http/request_head.h"

namespace freelsd {

class BodyReader {
 public:
  // `buffered`: bytes already read after the head. `socket` and `buffered` must outlive the reader.
  BodyReader(const ClientSocket& socket, const RequestHead& head, std::string& buffered);

  // Limits the whole body. Throws ApiError BodyTooLarge at once if Content-Length is larger, else
  // when the body exceeds the limit.
  void LimitTo(uint64_t max_bytes);
  // For a body that arrives as events happen, for example a stream of frames: sets how long the
  // next bytes may take, and switches off the check of the mean rate.
  void WaitFor(std::chrono::seconds idle_timeout) {
    idle_timeout_ = idle_timeout;
    is_live_ = true;
  }
  // Reads up to `size` bytes; 0 at the end. Throws ApiError BodyTooLarge, RequestTimeout, or
  // InvalidRequest if chunks are malformed or the client disconnects early.
  size_t Read(char* bytes, size_t size);
  std::string ReadAll(uint64_t max_bytes);
  bool IsAtEnd() const { return is_at_end_; }
  // Reads and drops a short rest of the body. False if it is long: the connection must then close.
  bool SkipRest();

 private:
  size_t ReadRaw(char* bytes, size_t size);
  void CheckRate() const;
  char ReadByte();
  void StartChunk();
  void EndChunk();
  void Count(size_t num_bytes);

  const ClientSocket& socket_;
  std::string& buffered_;
  bool is_chunked_;
  bool must_continue_;
  bool is_at_end_;
  // Bytes left in the body, or in the current chunk.
  uint64_t num_left_ = 0;
  uint64_t num_read_ = 0;
  // A handler sets it before it reads.
  uint64_t max_bytes_ = 0;
  std::chrono::seconds idle_timeout_{10};
  bool is_live_ = false;
  SteadyTime begin_ = std::chrono::steady_clock::now();
};

}  // namespace freelsd
