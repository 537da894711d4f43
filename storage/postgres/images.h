// Removes image files that nothing refers to. An image's file changes only under the lock of its
// row, so two processes never write and remove the same file at the same time.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

struct PostgresState;

// Removes each image that neither a frame nor a photo tile refers to.
void RemoveUnusedImages(PostgresState& state, const std::vector<std::string>& images);
// Removes unused images that are older than unused_image_age_s. Does nothing if a process has done
// so within that time.
void SweepImages(PostgresState& state);

}  // namespace freelsd
