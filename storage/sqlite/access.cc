// How the stores read and write both databases.
#include <algorithm>

#include "storage/sqlite/changes.h"
#include "storage/sqlite/dialect.h"
#include "storage/sqlite/state.h"

namespace freelsd {
namespace {

// Its destructor increases the version, whether the change succeeded or failed.
class VersionStep {
 public:
  explicit VersionStep(std::atomic<uint64_t>& version) : version_(version) {}
  ~VersionStep() { ++version_; }
  VersionStep(const VersionStep&) = delete;
  VersionStep& operator=(const VersionStep&) = delete;

 private:
  std::atomic<uint64_t>& version_;
};

class SqliteTurn final : public Turn {
 public:
  explicit SqliteTurn(StorageState& state) : state_(state), lock_(state.turns_mutex) {}
  void Write(Teller teller, const std::function<void(Writer&)>& act) override {
    static_cast<StoreAccess&>(state_).Write(act, Writing::kSites, teller);
    lock_.unlock();
  }

 private:
  StorageState& state_;
  std::unique_lock<std::mutex> lock_;
};

}  // namespace

const Dialect& StorageState::dialect() const {
  static const Dialect kDialect = SqliteDialect();
  return kDialect;
}

std::unique_ptr<Turn> StorageState::TakeTurn() { return std::make_unique<SqliteTurn>(*this); }

int64_t StorageState::NextMapNumber(const std::string& flight_id) {
  const auto write_lock = LockForWriting();
  const int64_t stored =
      writer.Int("SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = $1", flight_id);
  int64_t& last = last_map_numbers[flight_id];
  return last = std::max({last + 1, stored + 1, first_map_number});
}

bool StorageState::IsImageNeeded(const std::string& sha256) {
  return writer.Has(
      "SELECT 1 FROM frames WHERE sha256 = $1 UNION ALL "
      "SELECT 1 FROM photo_tiles WHERE sha256 = $1 LIMIT 1",
      sha256);
}

void StorageState::ReadWith(Reading from, const std::function<void(Database&)>& act) {
  if (from == Reading::kMain) return act(*Reader(readers));
  if (from == Reading::kSites || !is_copy_whole || is_copy_damaged_) return ReadSites(act);
  try {
    act(*Reader(copy_readers));
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    MarkCopyDamaged(error.what());
    ReadSites(act);
  }
}

void StorageState::ReadSites(const std::function<void(Database&)>& act) {
  if (is_damaged) return act(*Reader(copy_readers));
  try {
    act(*Reader(readers));
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    MarkDamaged(error.what());
    act(*Reader(copy_readers));
  }
}

void StorageState::WriteWith(Writing what, Teller teller, const Act& act) {
  const auto write_lock = LockForWriting();
  Writer own{writer};
  if (what == Writing::kRows) {
    Transaction transaction(writer);
    act(own);
    transaction.Commit();
  } else if (what == Writing::kSites) {
    WriteSites(own, teller, act);
  } else if (what == Writing::kObstacles) {
    const VersionStep step(obstacles_version);
    WriteSites(own, teller, act);
  } else {
    WriteUnseen(own, act);
  }
  for (const std::string& sha256 : own.retired_images) images.Remove(sha256);
  try {
    for (const std::string& sha256 : own.unused_images) {
      if (!IsImageNeeded(sha256)) images.Remove(sha256);
    }
  } catch (const StorageError& error) {
    // It is stored all the same; the next start removes the images.
    if (log) log(std::string("unused images were left: ") + error.what());
  }
}

void StorageState::WriteSites(Writer& own, Teller teller, const Act& act) {
  const VersionStep step(sites_version);
  Transaction transaction(writer);
  if (teller == Teller::kAbove) writer.Execute("UPDATE feed SET is_from_above = 1");
  act(own);
  if (teller == Teller::kAbove) writer.Execute("UPDATE feed SET is_from_above = 0");
  const std::unique_ptr<Transaction> copy = PrepareCopy();
  transaction.Commit();
  if (!copy) return;
  try {
    copy->Commit();
    is_copy_whole = !is_copy_damaged_;
  } catch (const StorageError& error) {
    // It is stored all the same; the next change, or the next start, brings it into the copy.
    is_copy_whole = false;
    if (log) log(std::string("the second copy is behind the database: ") + error.what());
  }
}

std::unique_ptr<Transaction> StorageState::PrepareCopy() {
  if (is_copy_damaged_) return nullptr;
  try {
    if (IsInStep(writer, copy_writer)) return nullptr;
    auto transaction = std::make_unique<Transaction>(copy_writer);
    FollowInCopy();
    copy_writer.ReserveCommit();
    return transaction;
  } catch (const CopyDamaged& error) {
    MarkCopyDamaged(error.what());
    return nullptr;
  }
}

void StorageState::WriteUnseen(Writer& own, const Act& act) {
  {
    Transaction transaction(writer);
    act(own);
    transaction.Commit();
  }
  if (is_copy_damaged_) return;
  try {
    On(copy_writer, [&act](Connection& connection) {
      Writer copy{connection, true};
      Transaction transaction(connection);
      act(copy);
      transaction.Commit();
    });
  } catch (const CopyDamaged& error) {
    MarkCopyDamaged(error.what());
  }
}

}  // namespace freelsd
