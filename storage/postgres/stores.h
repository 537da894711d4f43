// The stores that PostgreSQL has for itself: each reads and writes through the state that all
// share.
#pragma once

#include "storage/storage.h"

namespace freelsd {

struct PostgresState;

class PostgresImageStore final : public ImageStore {
 public:
  explicit PostgresImageStore(PostgresState& state) : state_(state) {}
  void Write(const std::string& sha256, std::string_view bytes) override;
  std::optional<std::string> Read(const std::string& sha256) const override;
  void RemoveUnused(const std::string& sha256) override;
  uint64_t NumBytes() const override;

 private:
  PostgresState& state_;
};

class PostgresClaimStore final : public ClaimStore {
 public:
  explicit PostgresClaimStore(PostgresState& state) : state_(state) {}
  bool IsShared() const override;
  std::optional<Claim> ClaimNext() override;
  std::vector<std::string> ListClaimed() const override;
  void Release(const std::string& flight_id) override;
  bool Renew() override;
  LeaseCounts CountLeases() const override;
  void Tell(const SharedEvent& event) override;
  std::vector<SharedEvent> ListTold(int64_t after_number, int limit) const override;
  int64_t LastTold() const override;
  void ForgetOldTold() override;

 private:
  PostgresState& state_;
};

}  // namespace freelsd
