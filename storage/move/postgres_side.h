// The PostgreSQL side of a move.
#pragma once

#include <memory>
#include <string>

#include "storage/move/rows.h"

namespace freelsd {

// Both throw StorageError if a server uses the database.
std::unique_ptr<RowSource> OpenPostgresSource(const std::string& url);
// While the move is unfinished, servers refuse the schema as a newer program's.
std::unique_ptr<RowTarget> OpenPostgresTarget(const std::string& url);

}  // namespace freelsd
