// When work that a full disk ended is tried again: it must neither be repeated for ever nor be
// forgotten.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

namespace freelsd {

// For one thread.
class RoomWait {
 public:
  // What a job that waits says.
  static constexpr char kReason[] = "the disk is full: the job goes on when there is room again";

  // After `longest` it may be tried even if no more room shows: some may be free within the
  // database.
  RoomWait(std::filesystem::path folder, std::chrono::seconds longest)
      : folder_(std::move(folder)), longest_(longest) {}

  // The disk has refused something.
  void Begin() { full_.emplace(Full{FreeBytes(), Clock::now()}); }
  void End() { full_.reset(); }
  bool IsBegun() const { return full_.has_value(); }
  // True if there is more room than when it began.
  bool HasMore() const { return !full_ || FreeBytes() > full_->free_bytes + kRoomBytes; }
  bool MayTry() const { return HasMore() || Clock::now() - full_->since > longest_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Full {
    uintmax_t free_bytes = 0;
    Clock::time_point since;
  };
  static constexpr uintmax_t kRoomBytes = 1 << 20;

  uintmax_t FreeBytes() const {
    std::error_code error;
    const auto space = std::filesystem::space(folder_, error);
    return error ? 0 : space.available;
  }

  std::filesystem::path folder_;
  std::chrono::seconds longest_;
  std::optional<Full> full_;
};

}  // namespace freelsd
