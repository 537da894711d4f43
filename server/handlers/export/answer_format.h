// The format in which a client wants an answer.
#pragma once

#include <string>
#include <vector>

#include "api/export/sites/sites.h"
#include "server/http/http.h"

namespace freelsd {

constexpr SiteFormat kReportFormat{"html", "text/html", "html"};

// The format that ?f= names, else the first one that the Accept header prefers. The first of
// `formats` is the answer if none matches, and for JSON of any kind. Throws ApiError InvalidQuery
// if ?f= names another format.
SiteFormat FormatOf(const Call& call, const std::vector<SiteFormat>& formats);

// A page that loads nothing and runs no script.
void AnswerReport(const std::string& page, httplib::Response& response);

}  // namespace freelsd
