// The picture of a flight's map on its way to storage.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

// The picture of a map that is not in force yet. If it is abandoned, MapStore::Discard removes all
// files that it has written, because their rows are stored before them.
class StagedPicture {
 public:
  StagedPicture(Storage& storage, std::string map_id)
      : storage_(storage), map_id_(std::move(map_id)) {}

  // `bytes`: the image file. It may be written later, but at the latest by Finish.
  void Add(const TileKey& place, std::string bytes);
  void Finish();

 private:
  struct File {
    std::string sha256;
    std::string bytes;
  };

  Storage& storage_;
  const std::string map_id_;
  // Not stored yet. One file for each row.
  PhotoTiles rows_;
  std::vector<File> files_;
};

}  // namespace freelsd
