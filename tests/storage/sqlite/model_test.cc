// Random changes, full disks, kills and damage, against a plain model of what must be stored.
#include "tests/storage/sqlite/model.h"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/storage/rows.h"
#include "tests/storage/small_disk.h"

namespace freelsd {
namespace {

constexpr int kNumIds = kNumModelFlights;
constexpr int64_t kNowUs = 1700000000000000;

// The files of both databases, as they are on disk at one moment.
using Files = std::map<std::string, std::string>;

class Machine {
 public:
  Machine(const std::filesystem::path& folder, const SmallDisk& disk, unsigned seed)
      : folder_(folder), disk_(disk), random_(seed) {
    Open();
  }

  void Step() {
    const int way = Below(100);
    if (way < 30) {
      PutObstacle();
    } else if (way < 42) {
      DeleteObstacle();
    } else if (way < 56) {
      PutSite();
    } else if (way < 62) {
      DeleteSite();
    } else if (way < 70) {
      Evaluate();
    } else if (way < 76) {
      InsertFlight();
    } else if (way < 80) {
      DeleteFlight();
    } else if (way < 88) {
      FillDisk();
    } else if (way < 93) {
      Kill(Read());
    } else if (way < 96) {
      KillBetweenCommits();
    } else {
      Damage();
    }
    Compare();
  }
  void Compare() {
    const Model stored = Stored(*storage_);
    CHECK_MESSAGE(stored == model_, what_, ":", ToldOf(stored), "\nnot", ToldOf(model_));
  }
  int num_refused() const { return num_refused_; }
  int num_accepted() const { return num_accepted_; }
  int num_kills() const { return num_kills_; }
  int num_damages() const { return num_damages_; }

 private:
  int Below(int limit) { return static_cast<int>(random_() % static_cast<unsigned>(limit)); }
  std::string SomeId(const std::string& kind) { return kind + std::to_string(Below(kNumIds)); }
  // Of a random size, so that some find no room.
  std::string NewText() {
    return R"({"v":)" + std::to_string(++version_) + R"(,"p":")" +
           std::string(static_cast<size_t>(1 << Below(13)), 'p') + "\"}";
  }
  std::string NewTile() {
    return std::to_string(++version_) + "-" + std::string(static_cast<size_t>(Below(40000)), 't');
  }

  void Open() {
    storage_.reset();
    storage_ = std::make_unique<Storage>(folder_);
  }

  // Applies `promise` to the model if the storage takes the change; a full disk may refuse it.
  template <typename Change, typename Promise>
  bool Try(const std::string& what, const Change& change, const Promise& promise) {
    what_ = what;
    try {
      change();
    } catch (const StorageError& error) {
      CHECK_MESSAGE(error.fault == StorageFault::kFull, what, ": ", error.what());
      ++num_refused_;
      return false;
    }
    promise();
    ++num_accepted_;
    return true;
  }

  bool PutObstacle() {
    const std::string id = SomeId("o"), text = NewText();
    return Try(
        "put obstacle " + id,
        [&] {
          storage_->obstacles.Put({{id, text, {7, 46, 8, 47}, std::nullopt, kNowUs}}, 0);
        },
        [&] { model_.obstacles[id] = text; });
  }
  void DeleteObstacle() {
    const std::string id = SomeId("o");
    Try(
        "delete obstacle " + id,
        [&] {
          const bool was_there = storage_->obstacles.Delete(id);
          CHECK(was_there == model_.obstacles.contains(id));
        },
        [&] { model_.obstacles.erase(id); });
  }

  SiteRow NewSite(const std::string& id) {
    SiteRow site = SomeSite(id, 47.0 + 0.1 * Below(10), 8.0);
    site.flight_id = "f" + id.substr(1);
    site.feature_json = NewText();
    // Stamps do not tell versions apart.
    site.updated_at_us = kNowUs;
    site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
    if (Below(4) == 0) site.superseded_by = "later";
    return site;
  }
  void Promise(const SiteRow& site) {
    model_.sites[site.id] = site.feature_json;
    model_.superseded.erase(site.id);
    if (site.superseded_by) model_.superseded.insert(site.id);
  }
  void Forget(const std::string& site_id) {
    model_.sites.erase(site_id);
    model_.superseded.erase(site_id);
  }
  void PutSite() {
    const SiteRow site = NewSite(SomeId("s"));
    Try(
        "put site " + site.id, [&] { freelsd::PutSite(*storage_, site); }, [&] { Promise(site); });
  }
  void DeleteSite() {
    const std::string id = SomeId("s");
    Try(
        "delete site " + id,
        [&] {
          const bool was_there = storage_->sites.Delete(id);
          CHECK(was_there == model_.sites.contains(id));
        },
        [&] { Forget(id); });
  }

  // A new map takes the place of the flight's former ones, with its site.
  void Evaluate() {
    const std::string number = std::to_string(Below(kNumIds)), flight = "f" + number;
    const std::string tile = NewTile();
    const SiteRow site = NewSite("s" + number);
    std::string map_id;
    EvaluationRows rows{{site}, {}, {}, {}};
    for (const FlightMapRow& map : storage_->maps.ListOf(flight)) {
      rows.forgotten_maps.push_back(map.id);
    }
    const bool is_stored = Try(
        "evaluate " + flight,
        [&] {
          map_id = storage_->maps.NewId(flight);
          storage_->maps.Stage(SomeMap(map_id, flight, {8, 47, 8.1, 47.1}), {}, {});
          storage_->maps.StageTiles(map_id, {{{0, 0, 0}, tile}}, {});
          rows.new_maps = {map_id};
          storage_->sites.PutEvaluation(rows, {});
        },
        [&] {
          for (const std::string& id : rows.forgotten_maps) model_.maps.erase(id);
          model_.maps[map_id] = tile;
          Promise(site);
        });
    if (is_stored || map_id.empty()) return;
    try {
      storage_->maps.Discard(map_id);
    } catch (const StorageError&) {
      // The next start removes it.
      return;
    }
  }

  void InsertFlight() {
    const std::string id = SomeId("f");
    if (!model_.flights.contains(id)) {
      Try(
          "insert flight " + id,
          [&] { storage_->flights.Insert(SomeFlight(id)); },
          [&] { model_.flights.insert(id); });
      return;
    }
    FrameRow frame = SomeFrame(id, "frame-" + std::to_string(++version_));
    frame.meta_json = NewText();
    Try(
        "insert frame of " + id,
        [&] {
          storage_->images.Write(frame.sha256, "image");
          storage_->frames.Insert(id, {frame}, std::nullopt, {});
        },
        [&] { model_.frames[id + "/" + frame.id] = frame.meta_json; });
  }
  void ForgetFlight(const std::string& id) {
    model_.flights.erase(id);
    std::erase_if(model_.frames,
                  [&](const auto& frame) { return frame.first.starts_with(id + "/"); });
  }
  void DeleteFlight() {
    const std::string id = SomeId("f");
    const bool forget_sites = Below(2) == 0, is_there = model_.flights.contains(id);
    Try(
        "delete flight " + id,
        [&] {
          if (!forget_sites) {
            const bool was_there = storage_->flights.Delete(id);
            CHECK(was_there == is_there);
            return;
          }
          EvaluationRows rows;
          rows.deleted_flight = id;
          rows.forgotten_sites = {"s" + id.substr(1)};
          for (const FlightMapRow& map : storage_->maps.ListOf(id)) {
            rows.forgotten_maps.push_back(map.id);
          }
          storage_->sites.PutEvaluation(rows, {});
        },
        [&] {
          ForgetFlight(id);
          if (!forget_sites) return;
          Forget("s" + id.substr(1));
          std::erase_if(model_.maps, [&](const auto& map) { return map.first.starts_with(id); });
        });
  }

  void FillDisk() {
    what_ = "fill disk";
    if (Below(3) == 0) return disk_.MakeRoom();
    disk_.Fill(static_cast<uint64_t>(Below(60)) << 12);
  }

  Files Read() const {
    Files files;
    for (const char* const name : {"freelsd.db", "recall.db"}) {
      for (const char* const suffix : {"", "-wal"}) {
        const std::string file = std::string(name) + suffix;
        std::ifstream stream(folder_ / file, std::ios::binary);
        if (stream) files[file] = std::string(std::istreambuf_iterator<char>(stream), {});
      }
    }
    return files;
  }
  // Opens what a kill would have left.
  void Kill(const Files& files) {
    what_ += ", kill";
    ++num_kills_;
    storage_.reset();
    // The files take the room that they had.
    disk_.MakeRoom();
    for (const char* const name : {"freelsd.db", "recall.db"}) {
      for (const char* const suffix : {"", "-wal", "-shm"}) {
        std::filesystem::remove(folder_ / (name + std::string(suffix)));
      }
    }
    for (const auto& [name, bytes] : files) {
      std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }
    Open();
  }
  // The client does not get an answer; the copy lacks the change, or there is none.
  void KillBetweenCommits() {
    Files files = Read();
    const Model before = model_;
    if (!PutObstacle()) return;
    const Files after = Read();
    for (const auto& [name, bytes] : after) {
      if (name.starts_with("freelsd.db")) files[name] = bytes;
    }
    if (Below(4) > 0) return Kill(files);
    // Damage at the same time: only what was promised stays.
    model_ = before;
    LoseFlights();
    files["freelsd.db"] = std::string(5000, '\xa5');
    files.erase("freelsd.db-wal");
    Kill(files);
    CleanUp();
  }

  // They have no second copy.
  void LoseFlights() {
    model_.flights.clear();
    model_.frames.clear();
  }
  void SpoilFile(const std::string& name) {
    const std::filesystem::path file = folder_ / name;
    const int way = Below(4);
    if (way == 0) return (void)std::filesystem::remove(file);
    if (way == 1) return std::filesystem::resize_file(file, static_cast<uint64_t>(Below(2000)));
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    const auto size = static_cast<int64_t>(std::filesystem::file_size(file));
    const int64_t begin = way == 2 ? 0 : 4096;
    stream.seekp(begin);
    stream << std::string(static_cast<size_t>(std::max<int64_t>(size - begin, 1)), '\xa5');
  }
  void Damage() {
    disk_.MakeRoom();
    storage_.reset();
    const int which = Below(10);
    const bool is_main = which < 5 || which == 9, is_copy = which >= 5;
    what_ = std::string("damage of") + (is_main ? " main" : "") + (is_copy ? " copy" : "");
    ++num_damages_;
    if (is_main) {
      SpoilFile("freelsd.db");
      LoseFlights();
    }
    if (is_copy) SpoilFile("recall.db");
    if (is_main && is_copy) model_ = {};
    Open();
    CheckNotice(is_main, is_copy);
    CleanUp();
  }
  // As an operator who has looked at it.
  void CleanUp() const {
    for (const auto& notice : storage_->ListNotices()) storage_->AcknowledgeNotice(notice.id);
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.path().filename().string().starts_with("damaged-")) {
        std::filesystem::remove_all(entry.path());
      }
    }
  }
  void CheckNotice(bool is_main, bool is_copy) const {
    // A new database without content.
    if (!is_main && storage_->changes.LastNumber() == 0) return;
    const std::vector<std::string> notices = storage_->Notices();
    REQUIRE_MESSAGE(notices.size() == 1, what_);
    const std::string wanted = is_main && is_copy ? "nothing could be restored"
                               : is_main          ? "restored from the second copy"
                                                  : "made anew from the database";
    CHECK_MESSAGE(notices[0].find(wanted) != std::string::npos, what_, ": ", notices[0]);
  }

  std::filesystem::path folder_;
  const SmallDisk& disk_;
  std::mt19937 random_;
  std::unique_ptr<Storage> storage_;
  Model model_;
  std::string what_;
  int version_ = 0;
  int num_refused_ = 0;
  int num_accepted_ = 0;
  int num_kills_ = 0;
  int num_damages_ = 0;
};

TEST_CASE("storage: full disks, kills and damage leave what was promised, and nothing else") {
  constexpr int kDefaultNumSteps = 400;
  const char* const given = std::getenv("FREELSD_MODEL_STEPS");
  const int num_steps = given == nullptr ? kDefaultNumSteps : std::atoi(given);
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "24m");
  if (!IsMounted(disk)) return;
  Machine machine(folder.path() / "disk", disk, 1);
  for (int i = 0; i < num_steps; ++i) {
    CAPTURE(i);
    machine.Step();
  }
  MESSAGE(num_steps,
          " steps: ",
          machine.num_accepted(),
          " accepted, ",
          machine.num_refused(),
          " refused, ",
          machine.num_kills(),
          " kills, ",
          machine.num_damages(),
          " damages");
  CHECK(machine.num_refused() > 0);
}

}  // namespace
}  // namespace freelsd
