// Errors as answers: problem+json.
#pragma once

#include <string>

#include "api/api.h"
#include "server/http/http_library.h"

namespace freelsd {

// Fills the response with the error, which nobody may keep.
void AnswerProblem(const ApiError& error, httplib::Response& response);

// The whole answer, head included, to a request that never reaches a handler. It closes the
// connection.
std::string RawProblem(const ApiError& error);

}  // namespace freelsd
