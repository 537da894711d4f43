#include "server/http/origin_check.h"

#include <algorithm>

#include "api/api.h"
#include "server/http/lower_case.h"

namespace freelsd {
namespace {

// "[::1]:8080" -> "[::1]", "localhost:8080" -> "localhost". Empty if what follows the name is no
// port: no part of "localhost:80@evil.com" is a name that may be compared.
std::string HostWithoutPort(const std::string& host) {
  const size_t bracket = host.find(']');
  const size_t colon = host.find(':', bracket == std::string::npos ? 0 : bracket);
  if (colon != std::string::npos &&
      host.find_first_not_of("0123456789", colon + 1) != std::string::npos) {
    return "";
  }
  return LowerCase(host.substr(0, colon));
}

}  // namespace

void CheckHostAndOrigin(const std::vector<std::string>& hosts,
                        const std::vector<std::string>& origins,
                        const std::vector<std::string>& allowed_hosts) {
  if (hosts.size() != 1) throw ApiError("InvalidRequest", "exactly one Host header is required");
  const std::string host = HostWithoutPort(hosts[0]);
  const bool is_loopback = host == "localhost" || host == "127.0.0.1" || host == "[::1]";
  if (!is_loopback &&
      std::find(allowed_hosts.begin(), allowed_hosts.end(), host) == allowed_hosts.end()) {
    throw ApiError("ForbiddenHost", "the host name is not allowed");
  }
  const std::string origin = origins.empty() ? "" : LowerCase(origins[0]);
  // https is our origin too: a reverse proxy may handle TLS.
  const bool is_ours =
      origin == "http://" + LowerCase(hosts[0]) || origin == "https://" + LowerCase(hosts[0]);
  if (!origins.empty() && (origins.size() > 1 || !is_ours)) {
    throw ApiError("ForbiddenOrigin", "requests from another origin are not accepted");
  }
}

void CheckFetchSite(const FetchMetadata& fetch, bool is_page) {
  if (LowerCase(fetch.site) != "cross-site") return;
  const bool opens_window =
      LowerCase(fetch.mode) == "navigate" && LowerCase(fetch.destination) == "document";
  if (is_page && opens_window) return;
  throw ApiError("ForbiddenOrigin", "requests from the page of another site are not accepted");
}

}  // namespace freelsd
