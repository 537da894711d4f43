#include "server/http/problem.h"

#include <optional>

namespace freelsd {

void AnswerProblem(const ApiError& error, httplib::Response& response) {
  response.status = error.http_status();
  response.set_content(ProblemJson(error), "application/problem+json");
  // The handler may have set those of the answer that it could not give.
  response.headers.erase("ETag");
  response.headers.erase("Cache-Control");
  response.set_header("Cache-Control", "no-store");
  if (const std::optional<int> seconds = RetryAfterSeconds(error.code())) {
    response.set_header("Retry-After", std::to_string(*seconds));
  }
  if (error.http_status() == 401) response.set_header("WWW-Authenticate", "Bearer");
}

std::string RawProblem(const ApiError& error) {
  const std::string body = ProblemJson(error);
  std::string more;
  if (error.http_status() == 405) more += "Allow: GET, HEAD, POST, PUT, DELETE\r\n";
  if (const std::optional<int> seconds = RetryAfterSeconds(error.code())) {
    more += "Retry-After: " + std::to_string(*seconds) + "\r\n";
  }
  return "HTTP/1.1 " + std::to_string(error.http_status()) + " " + error.code() +
         "\r\nContent-Type: application/problem+json\r\nCache-Control: no-store\r\n"
         "Connection: close\r\n" +
         more + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

}  // namespace freelsd
