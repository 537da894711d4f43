#include <algorithm>
#include <iterator>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {
namespace {

struct ErrorKind {
  const char* code;
  int http_status;
  const char* title;
  // 0: a retry of the same request cannot succeed.
  int retry_after_s;
};

// Every code of the contract. Clients depend on the codes, so none is ever renamed.
constexpr ErrorKind kErrorKinds[] = {
    {"InvalidJson", 400, "The JSON cannot be parsed", 0},
    {"InvalidQuery", 400, "A query parameter cannot be parsed", 0},
    {"UnknownParameter", 400, "A query parameter is unknown", 0},
    {"InvalidRequest", 400, "The request cannot be parsed", 0},
    {"InvalidMultipart", 400, "The multipart body cannot be parsed", 0},
    {"Unauthorized", 401, "A valid token is needed", 0},
    {"Forbidden", 403, "The token's scope does not allow this", 0},
    {"ForbiddenOrigin", 403, "Requests from this origin are not accepted", 0},
    {"ForbiddenHost", 403, "The Host header is not allowed", 0},
    {"NotFound", 404, "The path does not exist", 0},
    {"NoSuchFlight", 404, "There is no such flight", 0},
    {"NoSuchFrame", 404, "There is no such frame", 0},
    {"NoSuchJob", 404, "There is no such job", 0},
    {"NoSuchRegion", 404, "There is no such region", 0},
    {"NoSuchSite", 404, "There is no such site", 0},
    {"NoSuchLayer", 404, "There is no such layer", 0},
    {"NoSuchNotice", 404, "There is no such notice", 0},
    {"NoSuchObstacle", 404, "There is no such obstacle", 0},
    {"NoSuchLink", 404, "There is no such link", 0},
    {"NoMap", 404, "The site has no map", 0},
    {"NoBaseMap", 404, "No base map is configured", 0},
    {"NoSuchTile", 404, "The base map has no such tile", 0},
    {"UnusableTile", 404, "The base map's tile cannot be shown", 0},
    {"MethodNotAllowed", 405, "The path does not support this method", 0},
    {"RequestTimeout", 408, "The request did not arrive in time", 1},
    {"Conflict", 409, "The request conflicts with what is stored", 0},
    {"FrameConflict", 409, "The frame is stored with another image or meta", 0},
    {"NoApproach", 409, "The site has no approach", 0},
    {"SiteRejected", 409, "The site is rejected", 0},
    {"MapMissing", 409, "A map has to be sent first", 0},
    {"SiteSuperseded", 409, "A later map refutes the site", 0},
    {"LinkSilent", 409, "The link is not heard", 1},
    {"LinkInUse", 409, "Another program reports as this link", 1},
    {"NothingInReach", 409, "No stored site is in reach", 0},
    {"NoMapYet", 409, "The flight has no map yet", 0},
    {"NothingToLookAt", 409, "No leg promises anything", 0},
    {"AltitudeUnknown", 409, "The reference of the altitudes is unknown", 0},
    {"LengthRequired", 411, "The body's length is needed", 0},
    {"TooLarge", 413, "A limit is exceeded", 0},
    {"BodyTooLarge", 413, "The body is too large", 0},
    {"ImageTooLarge", 413, "The image is too large", 0},
    {"JsonTooLarge", 413, "The JSON is too large", 0},
    {"PosesTooLarge", 413, "The pose file is too large", 0},
    {"ZipTooLarge", 413, "The zip archive exceeds a limit", 0},
    {"TooManyObstacles", 413, "There are too many obstacles", 0},
    {"TooManyParts", 413, "There are too many parts", 0},
    {"UriTooLong", 414, "The URL is too long", 0},
    {"UnsupportedImage", 415, "The image is neither JPEG nor PNG", 0},
    {"UnsupportedMediaType", 415, "The body's type is not supported", 0},
    {"RangeNotSatisfiable", 416, "The range cannot be served", 0},
    {"InvalidValue", 422, "A value is not valid", 0},
    {"UnknownKey", 422, "A key is unknown", 0},
    {"RetiredOption", 422, "The option is retired", 0},
    {"SurfaceNotMeasured", 422, "The surface is not told well enough", 0},
    {"InvalidId", 422, "The id is not valid", 0},
    {"InvalidAirspace", 422, "The airspace file cannot be used", 0},
    {"InvalidPoses", 422, "The pose file cannot be used", 0},
    {"UnknownImages", 422, "Poses name images that do not exist", 0},
    {"DuplicateId", 422, "Two files have the same id", 0},
    {"MissingPart", 422, "A part is missing", 0},
    {"UnknownPart", 422, "A part is unknown", 0},
    {"DamagedImage", 422, "The image is damaged", 0},
    {"UnsupportedPixels", 422, "The image's pixel format is not supported", 0},
    {"ImageSizeMismatch", 422, "The image and the camera differ in size", 0},
    {"DigestMismatch", 422, "The body does not match its digest", 0},
    {"OddPhotograph", 422, "The photograph does not fit the others of its batch", 0},
    {"NoPosition", 422, "The frame has no position", 0},
    {"NoCamera", 422, "The camera is unknown", 0},
    {"ZipRefused", 422, "The zip archive is refused", 0},
    {"TooManyLinks", 429, "Too many links report", 5},
    {"TooManyRequests", 429, "Too many requests", 1},
    {"QueueFull", 429, "The frame queue is full", 1},
    {"HeadersTooLarge", 431, "The request's headers are too large", 0},
    {"InternalError", 500, "The server failed", 0},
    {"Unavailable", 503, "The server cannot do this now", 2},
    {"ShuttingDown", 503, "The server is stopping", 5},
    {"StorageFull", 507, "The disk is full", 30},
};

const ErrorKind* FindKind(const std::string& code) {
  const auto* const kind =
      std::find_if(std::begin(kErrorKinds), std::end(kErrorKinds), [&code](const ErrorKind& each) {
        return each.code == code;
      });
  return kind == std::end(kErrorKinds) ? nullptr : kind;
}

const char* TitleOfStatus(int http_status) {
  const auto* const kind = std::find_if(
      std::begin(kErrorKinds), std::end(kErrorKinds), [http_status](const ErrorKind& each) {
        return each.http_status == http_status;
      });
  return kind == std::end(kErrorKinds) ? "The request failed" : kind->title;
}

nlohmann::json Problem(int http_status, const std::string& code, const std::string& detail) {
  const ErrorKind* const kind = FindKind(code);
  return {{"type", "urn:freelsd:error:" + code},
          {"title", kind == nullptr ? TitleOfStatus(http_status) : kind->title},
          {"status", http_status},
          {"detail", detail},
          {"code", code},
          {"errors", nlohmann::json::array()},
          {"retryable", RetryAfterSeconds(code).has_value()}};
}

// A detail may quote bytes from a client. Bytes that are not UTF-8 must not break the answer.
std::string Dump(const nlohmann::json& problem) {
  return problem.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

ApiError::ApiError(std::string code, const std::string& detail, std::vector<FieldError> errors)
    : std::runtime_error(detail), code_(std::move(code)), errors_(std::move(errors)) {}

int ApiError::http_status() const {
  const ErrorKind* const kind = FindKind(code_);
  return kind == nullptr ? 500 : kind->http_status;
}

std::string ProblemJson(const ApiError& error) {
  nlohmann::json problem = Problem(error.http_status(), error.code(), error.what());
  for (const FieldError& each : error.errors()) {
    problem["errors"].push_back({{"pointer", each.pointer}, {"detail", each.detail}});
  }
  if (error.limit) problem["limit"] = *error.limit;
  if (error.observed) problem["observed"] = *error.observed;
  return Dump(problem);
}

std::string ProblemJson(int http_status, const std::string& code, const std::string& detail) {
  return Dump(Problem(http_status, code, detail));
}

std::optional<int> RetryAfterSeconds(const std::string& code) {
  const ErrorKind* const kind = FindKind(code);
  if (kind == nullptr || kind->retry_after_s == 0) return std::nullopt;
  return kind->retry_after_s;
}

}  // namespace freelsd
