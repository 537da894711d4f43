// Older schemas brought up to schema.sql.
#pragma once

#include "storage/sqlite.h"

namespace freelsd {

constexpr int kSchemaVersion = 3;

// From `version` (1 or more) to kSchemaVersion, within a transaction of the caller.
void Migrate(const Connection& writer, int64_t version);

}  // namespace freelsd
