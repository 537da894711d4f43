// Refuses requests that a foreign web page sends through the browser of a user of this server.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// `hosts`, `origins`: the values of all Host and Origin headers of a request. `allowed_hosts`:
// lower case, without port; loopback names are always allowed. Throws ApiError InvalidRequest,
// ForbiddenHost or ForbiddenOrigin.
//
// The check of the host stops a page that reaches this server under the page's own host name (DNS
// rebinding). The check of the origin stops requests that a page of another origin sends.
void CheckHostAndOrigin(const std::vector<std::string>& hosts,
                        const std::vector<std::string>& origins,
                        const std::vector<std::string>& allowed_hosts);

// The values of a request's Sec-Fetch headers, which browsers send; empty: absent.
struct FetchMetadata {
  std::string site;
  std::string mode;
  std::string destination;
};

// Throws ApiError ForbiddenOrigin if another site's page made the browser send the request, for
// example by an <img>, which has no Origin. `is_page`: the request asks for a file of our own page.
// A link from another site may open that in a window of its own.
void CheckFetchSite(const FetchMetadata& fetch, bool is_page);

}  // namespace freelsd
