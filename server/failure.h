// What a failure of the engine is told as.
#pragma once

#include <exception>
#include <string>

#include "storage/storage.h"

namespace freelsd {

// For clients: without source files.
std::string Sentence(const std::exception& error);
void FailJob(Storage& storage, JobRow job, const std::string& why);

}  // namespace freelsd
