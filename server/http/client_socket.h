// One accepted TCP connection. Reads have a deadline; a write sends all bytes. The destructor
// closes the connection.
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
  // True if bytes, or the end of the client's data, arrive before the deadline.
  bool IsReadableBefore(SteadyTime deadline) const;
  // Number of bytes read; 0 if the client ended, the deadline passed, or the connection broke.
  size_t Read(char* bytes, size_t size, SteadyTime deadline) const;
  // False if the client reads too slowly or disconnected.
  bool Write(std::string_view bytes) const;
  // Ends our side and reads for a while what the client still sends. Closing at once could discard
  // an answer that the client has not read yet.
  void Linger() const;

 private:
  int descriptor_;
};

}  // namespace freelsd
