// Which stored sites are worth a new look first.
#pragma once

#include "server/http/http.h"
#include "server/jobs/jobs.h"

namespace freelsd {

// GET /v1/sites?order=new_look: landable and unverified sites whose plan holds, by what a new look
// at their ground gains. The value of a site is its score, or half of it for an unverified site.
// The gain is the part of this value that the age of its photographs has taken, as recall counts
// it. Ties are ordered by id.
void GetSitesByNewLook(Service& service, const Call& call, httplib::Response& response);

}  // namespace freelsd
