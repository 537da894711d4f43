#include "storage/image_store.h"

#include <filesystem>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

size_t NumFiles(const std::filesystem::path& folder) {
  size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    count += entry.is_regular_file() ? 1 : 0;
  }
  return count;
}

TEST_CASE("image store: an image that was written for nothing can be taken back") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "used");
  storage.images.Write(kOtherImage, "unused");
  storage.frames.Insert("f", {SomeFrame("f", "one")});
  storage.images.RemoveUnused(kImage);
  storage.images.RemoveUnused(kOtherImage);
  CHECK(storage.images.Read(kImage) == "used");
  CHECK_FALSE(storage.images.Read(kOtherImage));
}

TEST_CASE("image store: image files that no frame names are removed at start") {
  const StoragePlace place;
  {
    Storage storage(place.options());
    storage.flights.Insert(SomeFlight("f"));
    storage.images.Write(kImage, "kept");
    storage.images.Write(kOtherImage, "left by a crash");
    storage.frames.Insert("f", {SomeFrame("f", "one")});
  }
  const Storage storage(place.options());
  CHECK(NumFiles(place.images_folder()) == 1);
  CHECK(storage.images.Read(kImage) == "kept");
}

}  // namespace
}  // namespace freelsd
