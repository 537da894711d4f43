#include "storage/storage_error.h"

namespace freelsd {

StorageError::StorageError(const std::string& step, const std::string& reason, StorageFault kind)
    : std::runtime_error(step + ": " + reason), fault(kind) {}

StorageError OtherSchema(const std::string& step, int64_t found, int64_t wanted) {
  return {step,
          "another version of freelsd wrote it, with schema number " + std::to_string(found) +
              " where this program reads number " + std::to_string(wanted) +
              " only, so nothing was changed: start with a new data folder, or with a new "
              "PostgreSQL database, and POST the photographs of each flight again",
          StorageFault::kOtherSchema};
}

}  // namespace freelsd
