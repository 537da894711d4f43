#include "storage/postgres/state.h"

#include <algorithm>
#include <set>
#include <utility>

#include "storage/postgres/dialect.h"
#include "storage/postgres/images.h"
#include "storage/postgres/schema.h"

namespace freelsd {
namespace {

std::filesystem::path MadeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw StorageError("create folder " + folder.string(), error.message());
  return folder;
}

StorageOptions Checked(const StorageOptions& options) {
  CheckDatabaseUrl(options.database_url);
  return options;
}

// What the database must be set to so that an acknowledged row survives a crash, and damage of its
// files is noticed.
std::vector<std::string> NoticesOf(PostgresConnection& connection) {
  std::vector<std::string> notices;
  if (connection.Run("SHOW fsync")[0].Text(0) != "on") {
    notices.emplace_back("PostgreSQL runs with fsync off: a power failure can lose the database");
  }
  if (connection.Run("SHOW full_page_writes")[0].Text(0) != "on") {
    notices.emplace_back(
        "PostgreSQL runs with full_page_writes off: a power failure can damage the database");
  }
  if (connection.Run("SHOW data_checksums")[0].Text(0) != "on") {
    notices.emplace_back(
        "PostgreSQL has no data checksums: damage of its files may stay unnoticed (see "
        "pg_checksums --enable)");
  }
  return notices;
}

void DeleteUnfinishedMaps(PostgresConnection& writer, double age_s) {
  writer.Run(
      "DELETE FROM maps WHERE NOT is_in_force AND staged_at <= now() - make_interval(secs => $1)",
      age_s);
}

}  // namespace

PostgresState::PostgresState(const StorageOptions& given)
    : options(Checked(given)),
      own_dialect(PostgresDialect(options.is_shared)),
      lock(MadeFolder(options.folder)),
      readers(options),
      writers(options),
      owner_pool(options),
      listener_pool(options),
      notices(options.folder / "notices", options.log_notice),
      images(Open()) {
  {
    PostgresWrite writer(*this);
    DeleteUnfinishedMaps(*writer, options.unused_image_age_s);
    writer.Commit();
  }
  CheckThatImagesAreThere();
  SweepImages(*this);
}

std::filesystem::path PostgresState::Open() {
  ownership.emplace(owner_pool, options.is_shared ? OwnershipKind::kShared : OwnershipKind::kAlone);
  {
    const ConnectionLease connection(writers);
    CreateSchema(*connection);
    origin = connection->Run("SELECT gen_random_uuid()::text")[0].Text(0);
    for (const std::string& text : NoticesOf(*connection)) notices.AddForNow(text);
  }
  ownership->Begin();
  if (options.is_shared && options.is_worker) registration.emplace(owner_pool, options.lease_s);
  return options.images_folder;
}

ConnectionPool& PostgresState::Writers() {
  if (is_damaged) throw StorageError("write", "the database is damaged");
  return writers;
}

void PostgresState::MarkDamaged(const std::string& why) {
  if (is_damaged.exchange(true)) return;
  notices.AddForNow("the database is damaged (" + why +
                    "): this server writes nothing until its next start");
}

namespace {

// The latest of this thread.
thread_local const HeldVersions* held_versions = nullptr;

}  // namespace

HeldVersions::HeldVersions(PostgresState& state) : state_(state), before_(held_versions) {
  if (before_ != nullptr && &before_->state_ == &state) {
    versions_ = before_->versions_;
  } else {
    versions_ = state.Read([](PostgresConnection& connection) {
      std::map<std::string, uint64_t> read;
      const PostgresRows rows = connection.Run("SELECT name, value FROM versions");
      for (int i = 0; i < rows.size(); ++i) {
        read[rows[i].Text(0)] = static_cast<uint64_t>(rows[i].Int(1));
      }
      return read;
    });
  }
  held_versions = this;
}

HeldVersions::~HeldVersions() { held_versions = before_; }

std::optional<uint64_t> HeldVersions::Find(const PostgresState& state, const std::string& name) {
  if (held_versions == nullptr || &held_versions->state_ != &state) return std::nullopt;
  const auto found = held_versions->versions_.find(name);
  return found == held_versions->versions_.end() ? std::nullopt : std::optional(found->second);
}

uint64_t PostgresState::VersionOf(const std::string& name) {
  if (const auto held = HeldVersions::Find(*this, name)) return *held;
  return Read([&](PostgresConnection& connection) {
    const PostgresRows rows = connection.Run("SELECT value FROM versions WHERE name = $1", name);
    if (rows.empty()) throw StorageError("read a version", "its row is missing");
    return static_cast<uint64_t>(rows[0].Int(0));
  });
}

// A server that sees another folder, or none, would take every stored photograph for lost.
void PostgresState::CheckThatImagesAreThere() {
  const std::vector<std::string> stored = Read([](PostgresConnection& connection) {
    return connection.Run("SELECT sha256 FROM images LIMIT 20").Texts();
  });
  const auto is_there = [this](const std::string& sha256) { return images.Has(sha256); };
  if (stored.empty() || std::any_of(stored.begin(), stored.end(), is_there)) return;
  throw StorageError("open the images",
                     "none of the stored ones is in " + options.images_folder.string() +
                         ": is the folder mounted?");
}

PostgresWrite::PostgresWrite(PostgresState& state) : PostgresTransaction(state.Writers()) {
  if (state.ownership) state.ownership->Check(**this);
  if (state.registration) state.registration->Check(**this);
}

namespace {

// Writers of sites then take turns until they commit.
void StepVersion(PostgresConnection& writer, const std::string& name) {
  writer.Run("UPDATE versions SET value = value + 1 WHERE name = $1", name);
}

void RemoveImagesOf(PostgresState& state, const Writer& writer) {
  std::set<std::string> images(writer.unused_images.begin(), writer.unused_images.end());
  images.insert(writer.retired_images.begin(), writer.retired_images.end());
  RemoveUnusedImages(state, {images.begin(), images.end()});
}

// Holds the row of the version of sites, which all who change sites need.
class PostgresTurn final : public Turn {
 public:
  explicit PostgresTurn(PostgresState& state) : state_(state), lock_(state.turns_mutex) {
    writer_.emplace(state_);
    StepVersion(**writer_, "sites");
  }
  void Write(Teller /*teller*/, const std::function<void(Writer&)>& act) override {
    Writer own{**writer_};
    act(own);
    writer_->Commit();
    writer_.reset();
    lock_.unlock();
    RemoveImagesOf(state_, own);
  }

 private:
  PostgresState& state_;
  // One connection of each process waits for the row.
  std::unique_lock<std::mutex> lock_;
  std::optional<PostgresWrite> writer_;
};

}  // namespace

std::unique_ptr<Turn> PostgresState::TakeTurn() { return std::make_unique<PostgresTurn>(*this); }

int64_t PostgresState::NextMapNumber(const std::string& flight_id) {
  PostgresWrite writer(*this);
  const PostgresRows rows = writer->Run(
      "INSERT INTO map_numbers (flight_id, last) "
      "VALUES ($1, 1 + (SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = $1)) "
      "ON CONFLICT (flight_id) DO UPDATE SET last = 1 + greatest(map_numbers.last, "
      "(SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = $1)) RETURNING last",
      flight_id);
  writer.Commit();
  return rows[0].Int(0);
}

void PostgresState::ReadWith(Reading /*from*/, const std::function<void(Database&)>& act) {
  Read([&act](PostgresConnection& connection) { act(connection); });
}

void PostgresState::WriteWith(Writing what,
                              Teller /*teller*/,
                              const std::function<void(Writer&)>& act) {
  std::optional<PostgresWrite> writer(std::in_place, *this);
  if (what == Writing::kObstacles) StepVersion(**writer, "obstacles");
  if (what == Writing::kObstacles || what == Writing::kSites) StepVersion(**writer, "sites");
  Writer own{**writer};
  act(own);
  writer->Commit();
  // Each image needs a transaction of its own.
  writer.reset();
  RemoveImagesOf(*this, own);
}

}  // namespace freelsd
