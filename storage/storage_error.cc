#include "storage/storage_error.h"

namespace freelsd {

StorageError::StorageError(const std::string& step, const std::string& reason, StorageFault kind)
    : std::runtime_error(step + ": " + reason), fault(kind) {}

}  // namespace freelsd
