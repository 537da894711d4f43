// Reports failures of the engine.
#pragma once

#include <exception>
#include <string>

#include "server/jobs/service.h"

namespace freelsd {

// The failure as a sentence for clients, without names of source files.
std::string Sentence(const std::exception& error);
void FailJob(Service& service, JobRow job, const std::string& why);

}  // namespace freelsd
