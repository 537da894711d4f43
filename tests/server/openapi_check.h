// Holds every answer that a test gets against the contract that the server serves.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/http/http_library.h"

namespace freelsd {

// Every answer that this client gets fails the running test where the contract does not say it.
void HoldAgainstContract(httplib::Client& client);

// What of an answer the contract does not say: path, method, status (each has to be named for its
// operation), media type, each value's type, range and key; and a server that failed (500). Empty
// where all is said.
std::vector<std::string> UndocumentedIn(const httplib::Request& request,
                                        const httplib::Response& response);
// Of a value against a schema of the contract; for tests of the check itself.
std::vector<std::string> SchemaErrors(const nlohmann::json& value, const nlohmann::json& schema);

}  // namespace freelsd
