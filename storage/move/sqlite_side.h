// The SQLite side of a move.
#pragma once

#include <filesystem>
#include <memory>

#include "storage/move/rows.h"

namespace freelsd {

// Both throw StorageError if a server uses the folder.
// Of a folder with the current schema.
std::unique_ptr<RowSource> OpenSqliteSource(const std::filesystem::path& folder);
// Fills a file beside the database's own name, which Complete renames.
std::unique_ptr<RowTarget> OpenSqliteTarget(const std::filesystem::path& folder);

}  // namespace freelsd
