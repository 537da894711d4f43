// The exception that storage throws.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace freelsd {

// kFull: the disk or a quota is full. kDamaged: the content of a database file is damaged.
// kOtherSchema: the database has a schema of another number. kConflict: another process has stored
// a row with the same key meanwhile.
enum class StorageFault { kOther, kFull, kDamaged, kOtherSchema, kConflict };

// Its text names the SQL statement or file operation that failed, and the reason.
class StorageError : public std::runtime_error {
 public:
  StorageError(const std::string& step,
               const std::string& reason,
               StorageFault fault = StorageFault::kOther);
  StorageFault fault;
};

// Says how to send the photographs again.
StorageError OtherSchema(const std::string& step, int64_t found, int64_t wanted);

}  // namespace freelsd
