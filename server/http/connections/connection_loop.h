// The poll loop of a listener: accepts connections, reads heads and small bodies, sends answers and
// live events. Another thread serves a request when the request is whole. A slow client therefore
// holds no thread, except while its large body is read.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "api/api.h"
#include "server/http/connections/connection_table.h"
#include "server/http/connections/poller.h"

namespace freelsd {

class ConnectionLoop {
 public:
  // Passes the request to another thread. That thread serves the request and then calls GiveBack.
  // `Serve` must not wait or throw.
  using Serve = std::function<void(ClientConnection&)>;

  // `rules` must outlive the loop. At most `max_num_served` requests without a large body are
  // passed at the same time.
  ConnectionLoop(const RequestRules& rules, int max_num_served);

  // Serves until another thread calls Stop, and all requests are served. `listening_socket` stays
  // open.
  void Run(int listening_socket, Serve serve);
  // Thread-safe.
  void Stop();
  void GiveBack(ClientConnection& connection);
  // Returns a function that makes the loop ask all live answers for text. The function is
  // thread-safe and may outlive the loop.
  std::function<void()> NewsCall() const;

 private:
  using Phase = ClientConnection::Phase;

  void Turn();

  // --- Reading requests ---
  void Accept();
  void Add(int descriptor);
  void OnReady(ClientConnection& connection);
  void Receive(ClientConnection& connection);
  void Advance(ClientConnection& connection);
  void AwaitRest(ClientConnection& connection, Phase phase);
  void StartServing(ClientConnection& connection, bool has_large_body);
  void ServeQueued();
  void Refuse(ClientConnection& connection, const ApiError& error);

  // --- Sending answers ---
  void TakeBack();
  void Flush(ClientConnection& connection);
  void AfterAnswer(ClientConnection& connection);
  void Linger(ClientConnection& connection);
  void FeedLive(ClientConnection& connection);
  void SendLive(ClientConnection& connection);
  void OnLiveReady(ClientConnection& connection);

  // --- Time ---
  void Sweep();
  void OnDeadline(ClientConnection& connection);
  void OnQuietLive(ClientConnection& connection);
  void CloseForStop();

  const RequestRules& rules_;
  int max_num_served_;
  Serve serve_;
  std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
  std::shared_ptr<std::atomic<bool>> has_news_ = std::make_shared<std::atomic<bool>>(false);
  std::atomic<bool> is_stopping_{false};
  Poller poller_;
  int listening_socket_ = -1;
  ConnectionTable connections_;
  // True if the process has no descriptor left for another connection. The next sweep tries again.
  bool is_paused_ = false;
  SteadyTime next_sweep_{};
  // Time at which Run noticed the call of Stop.
  std::optional<SteadyTime> stopped_at_;
  // Guards served_.
  std::mutex mutex_;
  std::vector<ClientConnection*> served_;
};

}  // namespace freelsd
