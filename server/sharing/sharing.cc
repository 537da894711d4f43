#include "server/sharing/sharing.h"

#include <utility>

#include <spdlog/spdlog.h>

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kLeasePeriod{1500};
constexpr std::chrono::milliseconds kCarryPeriod{250};
constexpr std::chrono::minutes kForgetPeriod{1};
// Of this server's events that wait to be told. More are left out: they only say what to fetch.
constexpr size_t kMaxNumWaiting = 4096;
constexpr int kMaxNumHeard = 500;

}  // namespace

Sharing::Sharing(Storage& storage, SharingCalls calls)
    : storage_(storage), calls_(std::move(calls)) {
  if (!storage_.claims.IsShared()) return;
  heard_ = storage_.claims.LastTold();
  sites_version_ = storage_.sites.Version();
}

void Sharing::CarryFrom(const std::string& organisation, EventLog& events) {
  if (!storage_.claims.IsShared()) return;
  events.CallWithPublished([this, organisation](const Event& event) {
    const std::lock_guard lock(mutex_);
    if (own_.size() >= kMaxNumWaiting) return;
    own_.push_back({0, event.type, event.flight_id, event.data, organisation});
  });
}

Sharing::~Sharing() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (lease_thread_.joinable()) lease_thread_.join();
  if (carrier_thread_.joinable()) carrier_thread_.join();
}

void Sharing::Start() {
  if (!storage_.claims.IsShared()) return;
  lease_thread_ = std::thread([this] { KeepLease(); });
  carrier_thread_ = std::thread([this] { Carry(); });
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

void Sharing::Carry() {
  do {
    try {
      TellOwn();
      HearOthers();
    } catch (const StorageError& error) {
      spdlog::warn("no news from other servers: {}", error.what());
    }
  } while (Wait(kCarryPeriod));
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
  bool has_heard = false;
  for (const SharedEvent& event : storage_.claims.ListTold(heard_, kMaxNumHeard)) {
    heard_ = event.number;
    has_heard = true;
    calls_.on_event(event);
  }
  if (has_heard) calls_.on_work();
  const uint64_t version = storage_.sites.Version();
  if (std::exchange(sites_version_, version) != version) calls_.on_changed_sites();
  const auto now = std::chrono::steady_clock::now();
  if (now - forgot_at_ < kForgetPeriod) return;
  forgot_at_ = now;
  storage_.claims.ForgetOldTold();
}

}  // namespace freelsd
