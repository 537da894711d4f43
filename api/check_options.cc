#include <stdexcept>

#include "api/json_reader.h"

namespace freelsd {

void CheckOptions(const PipelineOptions& options) {
  try {
    options.Check();
  } catch (const std::invalid_argument& error) {
    throw FromCheck(error, "/options", "");
  }
}

}  // namespace freelsd
