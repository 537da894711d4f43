// One accepted TCP connection: reads with deadlines, writes whole. Closes at the end.
#pragma once

#include <chrono>
#include <string_view>

namespace freelsd {

using SteadyTime = std::chrono::steady_clock::time_point;

class ClientSocket {
 public:
  explicit ClientSocket(int descriptor);
  ~ClientSocket();
  ClientSocket(const ClientSocket&) = delete;
  ClientSocket& operator=(const ClientSocket&) = delete;

  int descriptor() const { return descriptor_; }
  // Whether bytes (or the client's end) can be read before the deadline.
  bool IsReadableBefore(SteadyTime deadline) const;
  // Bytes read; 0 when the client has ended, the deadline has passed, or the connection is broken.
  size_t Read(char* bytes, size_t size, SteadyTime deadline) const;
  // False when the client takes too long or is gone.
  bool Write(std::string_view bytes) const;
  // Says that no more comes, and takes what the client still sends for a while: closing at once
  // would throw away the answer that it has not read yet.
  void Linger() const;

 private:
  int descriptor_;
};

}  // namespace freelsd
