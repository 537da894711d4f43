// A job as it is answered, and what its detail holds.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/http_library.h"
#include "server/service.h"

namespace freelsd {

nlohmann::json JobJson(const JobRow& job);
// Stores the job and tells listeners of it.
void UpdateJob(Service& service, const JobRow& job);
// 202 with the job.
void AnswerJob(const JobRow& job, httplib::Response& response);
// Sequence number of the last frame that a job waits for; 0 for none.
int64_t LastSequenceOf(const JobRow& job, const Storage& storage);

}  // namespace freelsd
