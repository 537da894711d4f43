// The stores that SQLite has for itself: each reads and writes through the state that all share.
#pragma once

#include "storage/storage.h"

namespace freelsd {

struct StorageState;

class SqliteImageStore final : public ImageStore {
 public:
  explicit SqliteImageStore(StorageState& state) : state_(state) {}
  void Write(const std::string& sha256, std::string_view bytes) override;
  std::optional<std::string> Read(const std::string& sha256) const override;
  void RemoveUnused(const std::string& sha256) override;
  uint64_t NumBytes() const override;

 private:
  StorageState& state_;
};

// One process has the folder for itself.
class SqliteClaimStore final : public ClaimStore {
 public:
  bool IsShared() const override { return false; }
  std::optional<Claim> ClaimNext() override { return std::nullopt; }
  std::vector<std::string> ListClaimed() const override { return {}; }
  void Release(const std::string& /*flight_id*/) override {}
  bool Renew() override { return true; }
  LeaseCounts CountLeases() const override { return {}; }
  void Tell(const SharedEvent& /*event*/) override {}
  std::vector<SharedEvent> ListTold(int64_t /*after_number*/, int /*limit*/) const override {
    return {};
  }
  int64_t LastTold() const override { return 0; }
  void ForgetOldTold() override {}
};

}  // namespace freelsd
