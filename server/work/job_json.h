// Converts a job to JSON for clients, and reads values from its detail_json.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/http/http.h"
#include "server/work/service.h"

namespace freelsd {

// The job as api/openapi.yaml describes it.
nlohmann::json JobJson(const JobRow& job);
// Stores the job and publishes an event.
void UpdateJob(Service& service, const JobRow& job);
// Answers 202 with the job.
void AnswerJob(const JobRow& job, httplib::Response& response);
// Sequence number of the last frame that the job waits for; 0 if it waits for none.
int64_t LastSequenceOf(const JobRow& job, const Storage& storage);

}  // namespace freelsd
