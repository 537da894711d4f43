// Older schemas brought up to schema.sql.
#pragma once

#include <cstdint>

#include "storage/sqlite.h"

namespace freelsd {

constexpr int kSchemaVersion = 3;

// Kept as application_id beside user_version: a file is a newer program's only where both say so,
// and damaged where one does.
constexpr int64_t ApplicationId(int64_t version) { return 0x666C7300 + version; }  // "fls"

// From `version` (1 or more) to kSchemaVersion, within a transaction of the caller.
void Migrate(const Connection& writer, int64_t version);

}  // namespace freelsd
