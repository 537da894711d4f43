#include "storage/storage.h"

#include "storage/sqlite/state.h"

namespace freelsd {
namespace {

// With less free space the service reports that it is not ready, so that results still fit.
constexpr uint64_t kMinFreeBytes = uint64_t{256} << 20;

}  // namespace

Storage::Storage(const std::filesystem::path& folder)
    : state_(OpenState(folder)),
      flights(*state_),
      frames(*state_),
      images(*state_),
      jobs(*state_),
      telemetry(*state_),
      sites(*state_),
      maps(*state_),
      obstacles(*state_) {
  std::error_code error;
  std::filesystem::remove_all(SpoolFolder(), error);
  std::filesystem::create_directories(SpoolFolder(), error);
  if (error) throw StorageError("create folder " + SpoolFolder().string(), error.message());
}

Storage::~Storage() = default;

std::filesystem::path Storage::SpoolFolder() const { return state_->folder / "spool"; }

void Storage::MarkDamaged(const std::string& why) const { state_->MarkDamaged(why); }

std::vector<std::string> Storage::Notices() const {
  const std::lock_guard lock(state_->notices_mutex);
  return state_->notices;
}

std::optional<std::string> Storage::WhyNotWritable() const {
  if (state_->is_damaged) return "the database is damaged";
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(state_->folder, error);
  if (error) return error.message();
  if (space.available < kMinFreeBytes) return "less than 256 MiB are free on the disk";
  try {
    const auto lock = state_->LockForWriting();
    const Transaction transaction(state_->writer);
  } catch (const StorageError& failure) {
    return failure.what();
  }
  return std::nullopt;
}

}  // namespace freelsd
