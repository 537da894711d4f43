// One accepted TCP connection. The destructor closes it. ReadNow and WriteNow never wait; Read and
// Write wait up to a deadline and are for threads that serve one large body.
#pragma once

#include <chrono>
#include <optional>
#include <string>
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
  // Number of bytes read. 0 if the client ended or the connection broke. Nothing if no byte has
  // arrived.
  std::optional<size_t> ReadNow(char* bytes, size_t size) const;
  // Number of bytes that the kernel accepted. Nothing if the connection broke.
  std::optional<size_t> WriteNow(std::string_view bytes) const;
  // Number of bytes read; 0 if the client ended, the deadline passed, or the connection broke.
  size_t Read(char* bytes, size_t size, SteadyTime deadline) const;
  // False if the client reads too slowly or disconnected.
  bool Write(std::string_view bytes) const;
  // True if the client ended or the connection broke, also if bytes before that are not read yet. A
  // client that only ended its own sending counts as one that left.
  bool HasEnded() const;
  // True if bytes have arrived that are not read yet.
  bool HasBytes() const;
  // The client's address without its port. Of IPv6 the network of 64 bits, because one client has
  // all of its addresses. Empty if there is none.
  std::string PeerNetwork() const;
  // Tells the client that no more bytes follow.
  void EndWriting() const;
  // Ends a Read that waits in another thread.
  void EndReading() const;

 private:
  int descriptor_;
};

}  // namespace freelsd
