// Reads the body of one request, which has a Content-Length or is chunked. Reads up to a limit, and
// only as much as the handler asks for. Only the thread that serves the request may use it.
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

  // Sets the limit of the whole body. Throws ApiError BodyTooLarge if Content-Length is larger;
  // Read throws it if a chunked body exceeds the limit.
  void LimitTo(uint64_t max_bytes);
  // For a body that arrives slowly because events produce it, for example a stream of frames. Sets
  // the longest time to wait for the next bytes, and disables the check of the mean rate.
  void WaitFor(std::chrono::seconds idle_timeout) {
    idle_timeout_ = idle_timeout;
    is_live_ = true;
  }
  // Reads up to `size` bytes; returns 0 at the end of the body. Throws ApiError BodyTooLarge,
  // RequestTimeout, or InvalidRequest if chunks are malformed or the client disconnects early.
  size_t Read(char* bytes, size_t size);
  std::string ReadAll(uint64_t max_bytes);
  bool IsAtEnd() const { return is_at_end_; }
  // For a handler that works long: whether anybody still waits for the answer.
  bool HasClientLeft() const { return socket_.HasEnded(); }
  // Reads and discards the rest of the body if it is short. Returns false if a part of the body is
  // left: the connection must then be closed.
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
  // The handler sets this limit before the first read.
  uint64_t max_bytes_ = 0;
  std::chrono::seconds idle_timeout_{10};
  bool is_live_ = false;
  SteadyTime begin_ = std::chrono::steady_clock::now();
};

}  // namespace freelsd
