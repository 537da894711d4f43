// The poll loop of a listener: accepts connections, reads heads and small bodies, sends answers and
// live events. A request is served by another thread, and only once it is whole; therefore a slow
// client holds no thread, except while its large body is read.
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
  // Makes another thread serve the request, which then calls GiveBack. Must not wait or throw.
  using Serve = std::function<void(Connection&)>;

  // `rules` must outlive the loop.
  explicit ConnectionLoop(const RequestRules& rules);

  // Serves until another thread calls Stop, and all requests are served. `listening_socket` stays
  // open.
  void Run(int listening_socket, Serve serve);
  // Thread-safe.
  void Stop();
  void GiveBack(Connection& connection);
  // A call that makes the loop ask all live answers for text. Thread-safe; may outlive the loop.
  std::function<void()> NewsCall() const;

 private:
  using Phase = Connection::Phase;

  void Turn();

  // --- Reading requests ---
  void Accept();
  void Add(int descriptor);
  void OnReady(Connection& connection);
  void Receive(Connection& connection);
  void Advance(Connection& connection);
  void AwaitRest(Connection& connection, Phase phase);
  void StartServing(Connection& connection, bool has_large_body);
  void Refuse(Connection& connection, const ApiError& error);

  // --- Sending answers ---
  void TakeBack();
  void Flush(Connection& connection);
  void AfterAnswer(Connection& connection);
  void Linger(Connection& connection);
  void FeedLive(Connection& connection);
  void SendLive(Connection& connection);
  void OnLiveReady(Connection& connection);

  // --- Time ---
  void Sweep();
  void OnDeadline(Connection& connection);
  void OnQuietLive(Connection& connection);
  void CloseForStop();

  const RequestRules& rules_;
  Serve serve_;
  std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
  std::shared_ptr<std::atomic<bool>> has_news_ = std::make_shared<std::atomic<bool>>(false);
  std::atomic<bool> is_stopping_{false};
  Poller poller_;
  int listening_socket_ = -1;
  ConnectionTable connections_;
  // The process has no descriptor left for a further connection; the next sweep tries again.
  bool is_paused_ = false;
  SteadyTime next_sweep_{};
  // When Run noticed the call of Stop.
  std::optional<SteadyTime> stopped_at_;
  // Guards served_.
  std::mutex mutex_;
  std::vector<Connection*> served_;
};

}  // namespace freelsd
