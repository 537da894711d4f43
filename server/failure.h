// What a failure of the engine is told as.
#pragma once

#include <exception>
#include <string>

#include "server/service.h"

namespace freelsd {

// For clients: without source files.
std::string Sentence(const std::exception& error);
void FailJob(Service& service, JobRow job, const std::string& why);

}  // namespace freelsd
