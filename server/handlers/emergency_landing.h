// Writes the best site of an emergency answer as a file for an autopilot.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "api/export/sites/sites.h"
#include "server/http/http.h"
#include "server/jobs/jobs.h"

namespace freelsd {

// `answer` is the result of RecallSites. The file contains the best site's plan from `answer`, not
// the stored plan. `format` is plan or waypoints. Throws ApiError NothingInReach, AltitudeUnknown.
void AnswerLanding(const Service& service,
                   const nlohmann::json& answer,
                   const std::string& format,
                   const ExportOptions& options,
                   httplib::Response& response);

}  // namespace freelsd
