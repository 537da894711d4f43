// Finds requests in the bytes of a connection as they arrive. It knows no sockets and never waits.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/api.h"
#include "server/http/request_head.h"

namespace freelsd {

// What a listener accepts.
struct RequestRules {
  HeadLimits head;
  // Lower case, without port.
  std::vector<std::string> allowed_hosts;
  // Larger bodies and chunked bodies count as large. They are read while the request is served.
  size_t max_small_body_bytes = kLimits.connection.max_small_body_bytes;
  // False: large bodies are refused.
  bool takes_large_bodies = true;
};

// Finds the end of a chunked body without taking it out of its buffer.
class ChunkScanner {
 public:
  // `bytes` begins with the body. Call it again when more bytes have arrived. True if the whole
  // body has arrived. Throws ApiError InvalidRequest.
  bool IsWhole(std::string_view bytes);

 private:
  // Begin of the first chunk that is not whole.
  size_t position_ = 0;
  bool is_in_trailer_ = false;
};

class RequestReader {
 public:
  enum class State {
    kNothing,    // no byte of a request has arrived
    kHead,       // a part of the head
    kBody,       // the head and a part of a small body
    kWhole,      // the head and the whole body
    kLargeBody,  // the head of a request with a large body
  };

  // `rules` must outlive the reader.
  explicit RequestReader(const RequestRules& rules) : rules_(rules) {}

  // Takes the head out of `buffered` once it is whole. The body stays there. Throws ApiError if the
  // request must be refused.
  State Advance(std::string& buffered);
  // Valid from State::kBody on.
  const RequestHead& head() const { return *head_; }
  // True if the client waits for "100 Continue" before it sends a small body. True only in the
  // first call.
  bool MustContinue();
  // True if bytes follow the body of known length: the client does not wait for the answer. Valid
  // from State::kBody on.
  bool HasNext(const std::string& buffered) const {
    return !head_->is_chunked && buffered.size() > head_->content_length.value_or(0);
  }
  // Begins the next request of the connection.
  void Reset();

 private:
  bool FindHead(std::string& buffered);
  State StateOfBody(const std::string& buffered);
  State StateOfChunks(const std::string& buffered);

  const RequestRules& rules_;
  std::optional<RequestHead> head_;
  ChunkScanner chunks_;
  // Number of bytes that were searched for the end of the head.
  size_t num_searched_ = 0;
};

}  // namespace freelsd
