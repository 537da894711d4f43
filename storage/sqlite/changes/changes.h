// For the feed of changes: whether the database is a copy that was put back. Its numbers of changes
// and of maps then go on from earlier ones, and a server that follows may know later ones that are
// lost here.
#pragma once

#include <cstdint>
#include <filesystem>

#include "storage/sqlite/sqlite.h"

namespace freelsd {

// Compares the database file (device and inode) with the one of the last start, which a file of the
// folder tells. If it is another one, gives the feed a new id: who follows begins anew. Returns the
// lowest number that no map had before the database was put back.
int64_t FirstMapNumberOf(const std::filesystem::path& folder,
                         const std::filesystem::path& database,
                         const Connection& writer);

}  // namespace freelsd
