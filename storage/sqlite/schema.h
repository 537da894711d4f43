// The number of schema.sql.
#pragma once

#include <cstdint>

namespace freelsd {

// Stored as user_version. Folders of another number are refused. It rises with each change of
// schema.sql and of stored JSON.
constexpr int64_t kSchemaNumber = 12;

// Stored as application_id beside user_version. Another program wrote the file only if both fields
// give the same other number; if only one of them does, the file is damaged.
constexpr int64_t ApplicationId(int64_t number) { return 0x666C7300 + number; }  // "fls"

}  // namespace freelsd
