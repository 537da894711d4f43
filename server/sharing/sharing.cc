#include "server/sharing/sharing.h"

#include <utility>

#include <spdlog/spdlog.h>

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kLeasePeriod{1500};
// Until others are heard again after a failure.
constexpr std::chrono::milliseconds kHearAgainAfter{250};
// Until something is told again after a failure.
constexpr std::chrono::milliseconds kTellAgainAfter{250};
constexpr std::chrono::minutes kForgetPeriod{1};
// Of this server's events that wait to be told. More are left out: they only say what to fetch.
constexpr size_t kMaxNumWaiting = 4096;
constexpr int kMaxNumHeard = 500;

// Others tell each step of their work, and whoever is woken looks for work in the database. What is
// missed here is found at the worker's next look by itself.
bool IsOfWork(const SharedEvent& event) {
  return (event.type == "frame" || event.type == "job") &&
         event.data.find("\"state\":\"queued\"") != std::string::npos;
}

}  // namespace

Sharing::Sharing(Storage& storage, EventLog& events, SharingCalls calls)
    : storage_(storage), calls_(std::move(calls)) {
  if (!storage_.claims.IsShared()) return;
  heard_ = storage_.claims.LastTold();
  sites_version_ = storage_.sites.Version();
  events.CallWithPublished([this](const Event& event) {
    const std::lock_guard lock(mutex_);
    if (own_.size() >= kMaxNumWaiting) return;
    own_.push_back({0, event.type, event.flight_id, event.data});
    changed_.notify_all();
  });
}

Sharing::~Sharing() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (lease_thread_.joinable()) lease_thread_.join();
  if (telling_thread_.joinable()) telling_thread_.join();
  if (hearing_thread_.joinable()) hearing_thread_.join();
}

void Sharing::Start() {
  if (!storage_.claims.IsShared()) return;
  lease_thread_ = std::thread([this] { KeepLease(); });
  telling_thread_ = std::thread([this] { Tell(); });
  hearing_thread_ = std::thread([this] { Hear(); });
}

bool Sharing::Wait(std::chrono::milliseconds period) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, period, [this] { return is_stopping_; });
}

void Sharing::KeepLease() {
  do {
    try {
      if (!storage_.claims.Renew()) calls_.on_lost_lease();
    } catch (const StorageError& error) {
      spdlog::warn("the lease was not renewed: {}", error.what());
    }
  } while (Wait(kLeasePeriod));
}

void Sharing::Tell() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_stopping_ || !own_.empty(); });
      if (is_stopping_) return;
    }
    try {
      TellOwn();
    } catch (const StorageError& error) {
      spdlog::warn("no news to other servers: {}", error.what());
      if (!Wait(kTellAgainAfter)) return;
    }
  }
}

void Sharing::Hear() {
  do {
    try {
      HearOthers();
    } catch (const StorageError& error) {
      spdlog::warn("no news from other servers: {}", error.what());
      if (!Wait(kHearAgainAfter)) return;
    }
  } while (Wait(std::chrono::milliseconds{0}));
}

void Sharing::TellOwn() {
  while (true) {
    SharedEvent event;
    {
      const std::lock_guard lock(mutex_);
      if (own_.empty()) return;
      event = own_.front();
    }
    storage_.claims.Tell(event);
    const std::lock_guard lock(mutex_);
    own_.pop_front();
  }
}

void Sharing::HearOthers() {
  bool may_be_work = false;
  for (const SharedEvent& event : storage_.claims.ListTold(heard_, kMaxNumHeard)) {
    heard_ = event.number;
    may_be_work = may_be_work || IsOfWork(event);
    calls_.on_event(event);
  }
  if (may_be_work) calls_.on_work();
  const uint64_t version = storage_.sites.Version();
  if (std::exchange(sites_version_, version) != version) calls_.on_changed_sites();
  const auto now = std::chrono::steady_clock::now();
  if (now - forgot_at_ < kForgetPeriod) return;
  forgot_at_ = now;
  storage_.claims.ForgetOldTold();
}

}  // namespace freelsd
