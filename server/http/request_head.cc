#include "server/http/request_head.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "api/api.h"
#include "server/http/lower_case.h"
#include "server/http/origin_check.h"

namespace freelsd {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

constexpr std::array<std::string_view, 7> kMethods{
    "GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH"};
// Headers that are not forwarded: BodyReader reads the body, ranges and compression are not
// offered, and a client must not set the headers that the library adds itself.
constexpr std::array<std::string_view, 9> kKeptBack{"content-length",
                                                    "transfer-encoding",
                                                    "expect",
                                                    "range",
                                                    "accept-encoding",
                                                    "remote_addr",
                                                    "remote_port",
                                                    "local_addr",
                                                    "local_port"};
constexpr size_t kMaxLengthDigits = 15;

[[noreturn]] void Refuse(const std::string& detail) { throw ApiError("InvalidRequest", detail); }

std::string Trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
}

bool IsToken(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string_view::npos;
  });
}

std::vector<std::string_view> SplitLines(std::string_view text, const HeadLimits& limits) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const size_t end = text.find("\r\n");
    if (end == std::string_view::npos) Refuse("the head has a line without CR LF");
    if (end == 0) break;
    if (end > limits.max_line_bytes) {
      throw ApiError("HeadersTooLarge", "a line of the head is too long");
    }
    lines.push_back(text.substr(0, end));
    if (lines.size() > limits.max_num_lines) {
      throw ApiError("HeadersTooLarge", "the head has too many lines");
    }
    text.remove_prefix(end + 2);
  }
  if (lines.empty()) Refuse("the request is empty");
  return lines;
}

bool HasEncodedControl(const std::string& value) {
  const std::string lower = LowerCase(value);
  return lower.find("%0a") != std::string::npos || lower.find("%0d") != std::string::npos ||
         lower.find("%00") != std::string::npos;
}

std::pair<std::string, std::string> ParseField(std::string_view line) {
  const size_t colon = line.find(':');
  if (colon == std::string_view::npos || !IsToken(line.substr(0, colon))) {
    Refuse("a header line is malformed");
  }
  std::string value = Trimmed(line.substr(colon + 1));
  const bool has_control = std::any_of(value.begin(), value.end(), [](unsigned char c) {
    return (c < 0x20 && c != '\t') || c == 0x7f;
  });
  if (has_control || HasEncodedControl(value)) Refuse("a header value has control characters");
  return {LowerCase(line.substr(0, colon)), std::move(value)};
}

void ParseRequestLine(std::string_view line, const HeadLimits& limits, RequestHead& head) {
  const size_t first = line.find(' ');
  const size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) Refuse("the request line is malformed");
  head.method = std::string(line.substr(0, first));
  head.target = std::string(line.substr(first + 1, last - first - 1));
  const std::string_view version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0")
    Refuse("only HTTP/1.1 and HTTP/1.0 are supported");
  if (head.target.size() > limits.max_target_bytes) {
    throw ApiError("UriTooLong",
                   "the URL is longer than " + std::to_string(limits.max_target_bytes) + " bytes");
  }
  const bool is_plain = std::all_of(
      head.target.begin(), head.target.end(), [](unsigned char c) { return c > 0x20 && c < 0x7f; });
  if (!is_plain || head.target.front() != '/') Refuse("the URL must be a path");
  if (std::find(kMethods.begin(), kMethods.end(), head.method) == kMethods.end()) {
    throw ApiError("MethodNotAllowed", "the method is not supported");
  }
}

std::vector<std::string> ValuesOf(const Fields& fields, std::string_view name) {
  std::vector<std::string> values;
  for (const auto& [key, value] : fields) {
    if (key == name) values.push_back(value);
  }
  return values;
}

void ParseBodyFields(const Fields& fields, RequestHead& head) {
  const std::vector<std::string> lengths = ValuesOf(fields, "content-length");
  const std::vector<std::string> encodings = ValuesOf(fields, "transfer-encoding");
  if (lengths.size() > 1) Refuse("Content-Length is given twice");
  if (!lengths.empty() && !encodings.empty())
    Refuse("Content-Length and Transfer-Encoding exclude each other");
  if (!encodings.empty()) {
    if (encodings.size() > 1 || LowerCase(encodings[0]) != "chunked") {
      Refuse("the only supported Transfer-Encoding is chunked");
    }
    head.is_chunked = true;
  }
  if (!lengths.empty()) {
    const std::string& digits = lengths[0];
    const bool is_number =
        !digits.empty() && digits.size() <= kMaxLengthDigits &&
        std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); });
    if (!is_number) Refuse("Content-Length is not a number of bytes");
    head.content_length = std::stoull(digits);
  }
  if (head.HasBody() && !ValuesOf(fields, "content-encoding").empty()) {
    throw ApiError("UnsupportedMediaType", "Content-Encoding is not supported");
  }
  const std::vector<std::string> expectations = ValuesOf(fields, "expect");
  head.expects_continue = !expectations.empty() && LowerCase(expectations[0]) == "100-continue";
  const bool takes_body = head.method == "POST" || head.method == "PUT" || head.method == "PATCH";
  if (head.HasBody() && !takes_body) Refuse("a " + head.method + " request must have no body");
}

}  // namespace

RequestHead ParseRequestHead(std::string_view text,
                             const HeadLimits& limits,
                             const std::vector<std::string>& allowed_hosts) {
  const std::vector<std::string_view> lines = SplitLines(text, limits);
  RequestHead head;
  ParseRequestLine(lines[0], limits, head);
  Fields fields;
  for (size_t i = 1; i < lines.size(); ++i) fields.push_back(ParseField(lines[i]));
  ParseBodyFields(fields, head);
  CheckHostAndOrigin(ValuesOf(fields, "host"), ValuesOf(fields, "origin"), allowed_hosts);
  head.forwarded = std::string(lines[0]) + "\r\n";
  for (const auto& [name, value] : fields) {
    if (std::find(kKeptBack.begin(), kKeptBack.end(), name) != kKeptBack.end()) continue;
    head.forwarded += name + ": " + value + "\r\n";
  }
  // Without a length of 0 the library waits for the end of the connection.
  head.forwarded += "content-length: 0\r\n\r\n";
  return head;
}

}  // namespace freelsd
