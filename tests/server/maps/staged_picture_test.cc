// Pictures of maps on their way to storage: each file that is written is named by a row.
#include "server/maps/staged_picture.h"

#include <set>

#include <doctest/doctest.h>

#include "tests/server/meadow_map.h"

namespace freelsd {
namespace {

std::set<std::string> FilesIn(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "images")) {
    if (entry.is_regular_file()) names.insert(entry.path().filename().string());
  }
  return names;
}

std::set<std::string> FilesOf(const Storage& storage, const std::string& map_id) {
  std::set<std::string> names;
  for (const auto& [place, sha256] : storage.maps.ListPhotoTiles(map_id, 0)) names.insert(sha256);
  return names;
}

void AddTiles(StagedPicture& picture, int num_tiles) {
  for (int i = 0; i < num_tiles; ++i) picture.Add({0, 0, i}, "tile " + std::to_string(i));
}

TEST_CASE("staged picture: if it ends early, no file is left without a row") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  const FlightMapRow map = StageMeadowMap(storage, Meadow());
  {
    StagedPicture picture(storage, map.id);
    AddTiles(picture, 100);
  }
  CHECK(FilesIn(folder.path()).size() > 50);
  CHECK(FilesIn(folder.path()) == FilesOf(storage, map.id));
  storage.maps.Discard(map.id);
  CHECK(FilesIn(folder.path()).empty());
}

TEST_CASE("staged picture: if a file cannot be written, those before it go with the map") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  const FlightMapRow map = StageMeadowMap(storage, Meadow());
  StagedPicture picture(storage, map.id);
  AddTiles(picture, 50);
  CHECK_FALSE(FilesIn(folder.path()).empty());
  // "last" has the digest 3547cb...
  std::filesystem::remove_all(folder.path() / "images" / "35");
  picture.Add({0, 1, 0}, "last");
  CHECK_THROWS_AS(picture.Finish(), StorageError);
  storage.maps.Discard(map.id);
  CHECK(FilesIn(folder.path()).empty());
}

TEST_CASE("staged picture: a file that another flight had stays when that flight is deleted") {
  for (const bool is_deleted_first : {false, true}) {
    const TemporaryFolder folder;
    Storage storage(StorageAt(folder.path()));
    std::string first_id, second_id;
    for (std::string* id : {&first_id, &second_id}) {
      *id = StageMeadowMap(storage, Meadow(), id == &first_id ? "f" : "g").id;
    }
    StagedPicture first(storage, first_id), second(storage, second_id);
    first.Add({0, 0, 0}, "sea");
    first.Finish();
    storage.sites.PutEvaluation({{}, {}, {first_id}, {}}, {});
    second.Add({0, 0, 0}, "sea");
    const auto forget_first = [&] { storage.sites.PutEvaluation({{}, {}, {}, {first_id}}, {}); };
    if (is_deleted_first) forget_first();
    second.Finish();
    if (!is_deleted_first) forget_first();
    const auto sha256 = storage.maps.FindPhotoTile(second_id, {0, 0, 0});
    REQUIRE(sha256);
    CHECK(storage.images.Read(*sha256) == "sea");
  }
}

}  // namespace
}  // namespace freelsd
