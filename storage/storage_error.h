// The exception that storage throws.
#pragma once

#include <stdexcept>
#include <string>

namespace freelsd {

// kFull: the disk or a quota is full. kDamaged: the content of a database file is damaged. kNewer:
// a newer program wrote the folder. kConflict: another process has stored a row with the same key
// meanwhile.
enum class StorageFault { kOther, kFull, kDamaged, kNewer, kConflict };

// Its text names the SQL statement or file operation that failed, and the reason.
class StorageError : public std::runtime_error {
 public:
  StorageError(const std::string& step,
               const std::string& reason,
               StorageFault fault = StorageFault::kOther);
  StorageFault fault;
};

}  // namespace freelsd
