// Migrates databases of older schema versions to schema.sql.
#pragma once

#include <cstdint>

#include "storage/sqlite/sqlite.h"

namespace freelsd {

constexpr int kSchemaVersion = 11;

// Stored as application_id beside user_version. A newer program wrote the file only if both fields
// give the same newer version; if only one of them gives a newer version, the file is damaged.
constexpr int64_t ApplicationId(int64_t version) { return 0x666C7300 + version; }  // "fls"

// Migrates from `version` (1 or more) to kSchemaVersion within the caller's transaction. Foreign
// keys must be off.
void Migrate(const Connection& writer, int64_t version);

}  // namespace freelsd
