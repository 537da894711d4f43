// One connection of a listener. The poll loop owns it; while a request is served, it belongs to the
// serving thread alone.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/client_socket.h"
#include "server/http/connections/request_reader.h"

namespace freelsd {

struct LiveText {
  std::string text;
  // The answer ends after this text.
  bool is_over = false;
};

// The rest of an answer that continues as events happen. The poll loop sends it.
struct LiveAnswer {
  // Returns the text since the last call; empty if there is none. Must not wait. Only one thread
  // calls it at a time.
  std::function<LiveText()> next;
  // Sent after a period without text.
  std::string heartbeat;
  std::chrono::milliseconds heartbeat_period{2000};
};

// Bytes of an answer that the client has not taken yet.
class UnsentBytes {
 public:
  void Append(std::string_view bytes) { bytes_.append(bytes); }
  bool empty() const { return num_sent_ == bytes_.size(); }
  size_t size() const { return bytes_.size() - num_sent_; }
  // Sends what the kernel accepts now. False if the connection broke.
  bool SendTo(const ClientSocket& socket);

 private:
  std::string bytes_;
  size_t num_sent_ = 0;
};

struct ClientConnection {
  // What the poll loop waits for in this phase.
  enum class Phase {
    kIdle,       // the first byte of a request
    kHead,       // the rest of a head
    kBody,       // the rest of a small body
    kQueued,     // a free thread; the request is whole
    kServing,    // the serving thread
    kWriting,    // a client that reads its answer
    kLive,       // events, or a client that reads them
    kLingering,  // the client's disconnection, because its request was not read completely
  };

  ClientConnection(int descriptor, const RequestRules& rules)
      : socket(descriptor), peer(socket.PeerNetwork()), request(rules) {}

  ClientSocket socket;
  // See ClientSocket::PeerNetwork.
  std::string peer;
  RequestReader request;
  // Bytes that arrived and that no request has taken.
  std::string input;
  UnsentBytes output;
  Phase phase = Phase::kIdle;
  // In kLive: when the last text was sent. In other phases: when the phase began.
  SteadyTime since{};
  SteadyTime deadline{};
  // True if the request's body is read while the request is served.
  bool has_large_body = false;
  // True if the client did not wait for the answer to the request before this one, or does not wait
  // for the answer to this one.
  bool is_pipelined = false;

  // --- Set by the serving thread ---
  std::optional<LiveAnswer> live;
  // True if the connection ends after the answer.
  bool is_last = false;
  // True if the request was not read completely. The connection is then closed later, because
  // closing it at once could discard an answer that the client has not read yet.
  bool must_linger = false;
  // True if bytes of the next request arrived before the answer was sent.
  bool has_next = false;
};

}  // namespace freelsd
