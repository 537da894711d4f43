// The body of one request, read as far as its handler wants: by length or chunked, never more than
// a limit, never held in memory unless asked for.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/client_socket.h"
#include "server/request_head.h"

namespace freelsd {

class BodyReader {
 public:
  // `buffered`: what was read from the socket beyond the head. Both are kept by reference.
  BodyReader(const ClientSocket& socket, const RequestHead& head, std::string& buffered);

  // All that follows counts against this; a longer Content-Length is refused at once.
  // Throws ApiError BodyTooLarge.
  void LimitTo(uint64_t max_bytes);
  // How long the next bytes may take to come, of a body that goes on as things happen: it may be
  // slow. Any other body has to keep up a least rate after its first seconds.
  void WaitFor(std::chrono::seconds idle_timeout) {
    idle_timeout_ = idle_timeout;
    is_live_ = true;
  }
  // Up to `size` bytes; 0 at the end. Throws ApiError: BodyTooLarge, RequestTimeout,
  // InvalidRequest for bad chunks or a client that leaves early.
  size_t Read(char* bytes, size_t size);
  std::string ReadAll(uint64_t max_bytes);
  bool IsAtEnd() const { return is_at_end_; }
  // Reads and drops a short rest, so that the connection can be kept. False when it is long.
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
  // Of the body, or of the current chunk.
  uint64_t num_left_ = 0;
  uint64_t num_read_ = 0;
  uint64_t max_bytes_ = 1 << 20;
  std::chrono::seconds idle_timeout_{10};
  bool is_live_ = false;
  SteadyTime begin_ = std::chrono::steady_clock::now();
};

}  // namespace freelsd
