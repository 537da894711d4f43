// What servers on one database tell each other.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "server/http/http.h"
#include "storage/storage.h"

namespace freelsd {

// What to do at news of other servers. Called by a thread of Sharing.
struct SharingCalls {
  // Something may be there to work on.
  std::function<void()> on_work;
  std::function<void()> on_changed_sites;
  // Another server published an event.
  std::function<void(const SharedEvent& event)> on_event;
  // This server's lease was over, and another one has its flights: it must end.
  std::function<void()> on_lost_lease;
};

// Carries events between this server and the others, and keeps its lease. Does nothing if the
// storage is not shared.
class Sharing {
 public:
  // `events`: nothing was published in it yet. Others get its events.
  Sharing(Storage& storage, EventLog& events, SharingCalls calls);
  ~Sharing();
  Sharing(const Sharing&) = delete;
  Sharing& operator=(const Sharing&) = delete;

  void Start();

 private:
  void KeepLease();
  void Tell();
  void Hear();
  void TellOwn();
  void HearOthers();
  // False if the server is stopping.
  bool Wait(std::chrono::milliseconds period);

  Storage& storage_;
  SharingCalls calls_;

  // Guards the next two members.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SharedEvent> own_;
  bool is_stopping_ = false;

  // They belong to the hearing thread.
  int64_t heard_ = 0;
  uint64_t sites_version_ = 0;
  std::chrono::steady_clock::time_point forgot_at_{};

  std::thread lease_thread_;
  std::thread telling_thread_;
  std::thread hearing_thread_;
};

}  // namespace freelsd
