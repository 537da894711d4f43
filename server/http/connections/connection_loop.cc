#include "server/http/connections/connection_loop.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <utility>

#include <fcntl.h>
#include <sys/socket.h>

#include "server/http/problem.h"

namespace freelsd {
namespace {

using std::chrono::milliseconds;

constexpr const ConnectionLimits& kLimitsOfConnections = kLimits.connection;
constexpr milliseconds kRequestTimeout{kLimitsOfConnections.max_request_ms};
constexpr milliseconds kIdleTimeout{kLimitsOfConnections.max_idle_s * 1000};
constexpr milliseconds kWritePause{kLimitsOfConnections.max_write_pause_s * 1000};
// For this time, a refused client may continue to send.
constexpr milliseconds kLingerTime{2000};
// Deadlines are checked in this period.
constexpr milliseconds kSweepPeriod{50};
// After Stop, the server waits this long for large bodies that still arrive, and for answers that
// clients still read.
constexpr milliseconds kBodyPatience{1000};
constexpr milliseconds kAnswerPatience{1500};
// Number of steps for one connection, or for the listening socket, before the others have their
// turn.
constexpr int kMaxNumAccepted = 64;
constexpr int kMaxNumTexts = 4;
constexpr size_t kReadBytes = 65536;

constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
constexpr std::string_view kLastChunk = "0\r\n\r\n";

SteadyTime Now() { return std::chrono::steady_clock::now(); }

std::string ChunkOf(const std::string& text) {
  std::array<char, 20> size{};
  std::snprintf(size.data(), size.size(), "%zx\r\n", text.size());
  return size.data() + text + "\r\n";
}

// Begins a phase of the connection.
void Enter(ClientConnection& connection, ClientConnection::Phase phase, milliseconds timeout) {
  connection.phase = phase;
  connection.since = Now();
  connection.deadline = connection.since + timeout;
}

bool IsOutOfDescriptors(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

}  // namespace

ConnectionLoop::ConnectionLoop(const RequestRules& rules, int max_num_served)
    : rules_(rules), max_num_served_(max_num_served), poller_(waker_) {}

void ConnectionLoop::Run(int listening_socket, Serve serve) {
  serve_ = std::move(serve);
  listening_socket_ = listening_socket;
  ::fcntl(listening_socket_, F_SETFL, ::fcntl(listening_socket_, F_GETFL) | O_NONBLOCK);
  poller_.Arm(listening_socket_, Poller::Interest::kRead);
  while (!is_stopping_ || !connections_.empty()) {
    try {
      Turn();
    } catch (const std::exception&) {
      // The process is probably out of memory. The next turn tries again.
      is_paused_ = true;
    }
  }
}

void ConnectionLoop::Turn() {
  // Without connections there is no deadline.
  const bool is_quiet = connections_.empty() && !is_paused_;
  const milliseconds timeout = is_quiet ? milliseconds(-1) : kSweepPeriod;
  for (const int descriptor : poller_.Ready(*has_news_ ? milliseconds(0) : timeout)) {
    if (descriptor == listening_socket_) {
      Accept();
    } else if (ClientConnection* const connection = connections_.Find(descriptor)) {
      // The descriptor may belong to another connection by now. Then there is nothing to read or to
      // write.
      connections_.Do(*connection, [this](ClientConnection& ready) { OnReady(ready); });
    }
  }
  TakeBack();
  ServeQueued();
  if (has_news_->exchange(false)) {
    connections_.ForEach(Phase::kLive, [this](ClientConnection& live) { FeedLive(live); });
  }
  if (Now() >= next_sweep_) Sweep();
  if (is_stopping_) CloseForStop();
}

void ConnectionLoop::Stop() {
  is_stopping_ = true;
  waker_->Wake();
}

void ConnectionLoop::GiveBack(ClientConnection& connection) {
  {
    const std::lock_guard lock(mutex_);
    served_.push_back(&connection);
  }
  waker_->Wake();
}

std::function<void()> ConnectionLoop::NewsCall() const {
  return [waker = waker_, has_news = has_news_] {
    if (!has_news->exchange(true)) waker->Wake();
  };
}

// --- Reading requests ---

void ConnectionLoop::Accept() {
  for (int i = 0; i < kMaxNumAccepted; ++i) {
    const int descriptor = ::accept4(listening_socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (descriptor >= 0) {
      Add(descriptor);
      continue;
    }
    if (IsOutOfDescriptors(errno) && !connections_.CloseOne()) {
      is_paused_ = true;
      return;
    }
    if (errno == EAGAIN || errno == EINVAL) break;
  }
  if (!is_stopping_) poller_.Arm(listening_socket_, Poller::Interest::kRead);
}

void ConnectionLoop::Add(int descriptor) {
  auto connection = std::make_unique<ClientConnection>(descriptor, rules_);
  if (!connections_.MakeRoomFor(connection->peer)) return;
  Enter(*connection, Phase::kIdle, kIdleTimeout);
  poller_.Arm(descriptor, Poller::Interest::kRead);
  connections_.Add(std::move(connection));
}

void ConnectionLoop::OnReady(ClientConnection& connection) {
  switch (connection.phase) {
    case Phase::kIdle:
    case Phase::kHead:
    case Phase::kBody:
      return Receive(connection);
    case Phase::kQueued:
    case Phase::kServing:
      return;
    case Phase::kWriting:
      return Flush(connection);
    case Phase::kLive:
      return OnLiveReady(connection);
    case Phase::kLingering:
      return Linger(connection);
  }
}

void ConnectionLoop::Receive(ClientConnection& connection) {
  std::array<char, kReadBytes> bytes;
  const std::optional<size_t> num_read = connection.socket.ReadNow(bytes.data(), bytes.size());
  if (num_read && *num_read == 0) {
    if (connection.phase == Phase::kIdle) return connections_.Close(connection);
    return Refuse(connection, ApiError("InvalidRequest", "the request ended early"));
  }
  connection.input.append(bytes.data(), num_read.value_or(0));
  Advance(connection);
}

void ConnectionLoop::Advance(ClientConnection& connection) {
  using State = RequestReader::State;
  try {
    switch (connection.request.Advance(connection.input)) {
      case State::kNothing:
        return AwaitRest(connection, Phase::kIdle);
      case State::kHead:
        return AwaitRest(connection, Phase::kHead);
      case State::kBody:
        if (connection.request.MustContinue()) connection.output.Append(kContinue);
        if (!connection.output.SendTo(connection.socket)) return connections_.Close(connection);
        return AwaitRest(connection, Phase::kBody);
      case State::kWhole:
        return StartServing(connection, false);
      case State::kLargeBody:
        return StartServing(connection, true);
    }
  } catch (const ApiError& error) {
    Refuse(connection, error);
  }
}

void ConnectionLoop::AwaitRest(ClientConnection& connection, Phase phase) {
  if (connection.phase != phase) {
    Enter(connection, phase, phase == Phase::kIdle ? kIdleTimeout : kRequestTimeout);
  }
  poller_.Arm(connection.socket.descriptor(), Poller::Interest::kRead);
}

void ConnectionLoop::StartServing(ClientConnection& connection, bool has_large_body) {
  if (has_large_body) {
    const int limit = kLimitsOfConnections.max_num_large_bodies;
    if (connections_.CountLargeBodies() >= limit) {
      return Refuse(connection,
                    ApiError("TooManyRequests", "too many large bodies at the same time"));
    }
  }
  connection.has_large_body = has_large_body;
  connection.is_pipelined = connection.has_next || connection.request.HasNext(connection.input);
  connection.phase = has_large_body ? Phase::kServing : Phase::kQueued;
  connection.since = Now();
  if (has_large_body) serve_(connection);
}

void ConnectionLoop::ServeQueued() {
  while (ClientConnection* const next = connections_.NextToServe(max_num_served_)) {
    next->phase = Phase::kServing;
    serve_(*next);
  }
}

void ConnectionLoop::Refuse(ClientConnection& connection, const ApiError& error) {
  connection.output.Append(RawProblem(error));
  connection.is_last = true;
  connection.must_linger = true;
  Flush(connection);
}

// --- Sending answers ---

void ConnectionLoop::TakeBack() {
  std::vector<ClientConnection*> served;
  {
    const std::lock_guard lock(mutex_);
    served.swap(served_);
  }
  for (ClientConnection* const connection : served) {
    connection->has_large_body = false;
    connections_.Do(*connection, [this](ClientConnection& answered) { Flush(answered); });
  }
}

void ConnectionLoop::Flush(ClientConnection& connection) {
  const size_t size_before = connection.output.size();
  if (!connection.output.SendTo(connection.socket)) return connections_.Close(connection);
  if (connection.output.empty()) return AfterAnswer(connection);
  if (connection.phase != Phase::kWriting) Enter(connection, Phase::kWriting, kWritePause);
  if (connection.output.size() < size_before) connection.deadline = Now() + kWritePause;
  poller_.Arm(connection.socket.descriptor(), Poller::Interest::kWrite);
}

void ConnectionLoop::AfterAnswer(ClientConnection& connection) {
  if (connection.live) {
    Enter(connection, Phase::kLive, kWritePause);
    return FeedLive(connection);
  }
  if (connection.must_linger) {
    connection.socket.EndWriting();
    Enter(connection, Phase::kLingering, kLingerTime);
    return Linger(connection);
  }
  if (connection.is_last || is_stopping_) return connections_.Close(connection);
  connection.request.Reset();
  // The next request may have arrived already.
  Advance(connection);
}

void ConnectionLoop::Linger(ClientConnection& connection) {
  std::array<char, kReadBytes> ignored;
  const std::optional<size_t> num_read = connection.socket.ReadNow(ignored.data(), ignored.size());
  if (num_read && *num_read == 0) return connections_.Close(connection);
  poller_.Arm(connection.socket.descriptor(), Poller::Interest::kRead);
}

void ConnectionLoop::FeedLive(ClientConnection& connection) {
  for (int i = 0; i < kMaxNumTexts && connection.output.empty(); ++i) {
    const LiveText news = connection.live->next();
    if (!news.text.empty()) connection.output.Append(ChunkOf(news.text));
    if (news.is_over) {
      connection.output.Append(kLastChunk);
      connection.live.reset();
      connection.is_last = true;
      return Flush(connection);
    }
    if (news.text.empty()) break;
    connection.since = Now();
    connection.deadline = connection.since + kWritePause;
    if (!connection.output.SendTo(connection.socket)) return connections_.Close(connection);
    // The others have their turn first.
    if (i + 1 == kMaxNumTexts) *has_news_ = true;
  }
  SendLive(connection);
}

void ConnectionLoop::SendLive(ClientConnection& connection) {
  const size_t size_before = connection.output.size();
  if (!connection.output.SendTo(connection.socket)) return connections_.Close(connection);
  if (connection.output.size() < size_before) {
    connection.deadline = Now() + kWritePause;
    // Text may have waited for this client.
    if (connection.output.empty()) *has_news_ = true;
  }
  poller_.Arm(
      connection.socket.descriptor(),
      connection.output.empty() ? Poller::Interest::kRead : Poller::Interest::kReadAndWrite);
}

void ConnectionLoop::OnLiveReady(ClientConnection& connection) {
  // A client that listens sends nothing; its end means that it left.
  std::array<char, 4096> ignored;
  const std::optional<size_t> num_read = connection.socket.ReadNow(ignored.data(), ignored.size());
  if (num_read && *num_read == 0) return connections_.Close(connection);
  SendLive(connection);
}

// --- Time ---

void ConnectionLoop::Sweep() {
  next_sweep_ = Now() + kSweepPeriod;
  if (is_paused_) poller_.Arm(listening_socket_, Poller::Interest::kRead);
  is_paused_ = false;
  for (const Phase phase :
       {Phase::kIdle, Phase::kHead, Phase::kBody, Phase::kWriting, Phase::kLingering}) {
    connections_.ForEach(phase, [this](ClientConnection& connection) { OnDeadline(connection); });
  }
  connections_.ForEach(Phase::kLive, [this](ClientConnection& live) { OnQuietLive(live); });
  connections_.LimitUnsent(kLimitsOfConnections.max_unsent_bytes);
}

void ConnectionLoop::OnDeadline(ClientConnection& connection) {
  if (Now() < connection.deadline) return;
  if (connection.phase == Phase::kHead) {
    return Refuse(connection, ApiError("RequestTimeout", "the head did not arrive in time"));
  }
  if (connection.phase == Phase::kBody) {
    return Refuse(connection, ApiError("RequestTimeout", "the body did not arrive in time"));
  }
  connections_.Close(connection);
}

void ConnectionLoop::OnQuietLive(ClientConnection& connection) {
  const SteadyTime now = Now();
  if (!connection.output.empty()) {
    if (now >= connection.deadline) connections_.Close(connection);
    return;
  }
  if (now < connection.since + connection.live->heartbeat_period) return;
  connection.output.Append(ChunkOf(connection.live->heartbeat));
  connection.since = now;
  connection.deadline = now + kWritePause;
  SendLive(connection);
}

void ConnectionLoop::CloseForStop() {
  const SteadyTime now = Now();
  if (!stopped_at_) {
    stopped_at_ = now;
    // Refuses new connections.
    ::shutdown(listening_socket_, SHUT_RDWR);
    // A live answer may have a last text.
    connections_.ForEach(Phase::kLive, [this](ClientConnection& live) { FeedLive(live); });
  }
  const auto close = [this](ClientConnection& connection) { connections_.Close(connection); };
  for (const Phase phase :
       {Phase::kIdle, Phase::kHead, Phase::kBody, Phase::kLive, Phase::kLingering}) {
    connections_.ForEach(phase, close);
  }
  if (now > *stopped_at_ + kAnswerPatience) {
    connections_.ForEach(Phase::kQueued, close);
    connections_.ForEach(Phase::kWriting, close);
  }
  if (now <= *stopped_at_ + kBodyPatience) return;
  connections_.ForEach(Phase::kServing, [](ClientConnection& connection) {
    if (connection.has_large_body) connection.socket.EndReading();
  });
}

}  // namespace freelsd
