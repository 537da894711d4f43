#include "server/maps/staged_picture.h"

#include "api/import/import.h"

namespace freelsd {

void StagedPicture::Add(const TileKey& place, std::string bytes) {
  // Some megabytes in memory, and one commit for all of them.
  constexpr size_t kNumTilesPerCommit = 32;
  files_.push_back({Sha256Hex(bytes), std::move(bytes)});
  rows_.emplace_back(place, files_.back().sha256);
  if (rows_.size() >= kNumTilesPerCommit) Finish();
}

// The rows come first. A file that is already stored is not written again, and only a row keeps it
// when the other flight that has it is deleted.
void StagedPicture::Finish() {
  storage_.maps.StageTiles(map_id_, {}, rows_);
  for (const auto& [sha256, bytes] : files_) storage_.images.Write(sha256, bytes);
  rows_.clear();
  files_.clear();
}

}  // namespace freelsd
