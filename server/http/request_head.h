// Parses and checks the head of an HTTP request before cpp-httplib parses it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/api.h"

namespace freelsd {

// A valid request head.
struct RequestHead {
  std::string method;
  std::string target;
  // Nothing if the request has no body, or a chunked one.
  std::optional<uint64_t> content_length;
  bool is_chunked = false;
  bool expects_continue = false;
  // The head that cpp-httplib parses. It lacks the headers about body transfer, ranges and
  // compression: BodyReader reads the body, and neither ranges nor compression are supported.
  std::string forwarded;

  bool HasBody() const { return is_chunked || content_length.value_or(0) > 0; }
};

// `text` includes the blank line at the end. `allowed_hosts`: lower case, without port; loopback
// names are always allowed. Throws ApiError.
RequestHead ParseRequestHead(std::string_view text,
                             const HeadLimits& limits,
                             const std::vector<std::string>& allowed_hosts);

}  // namespace freelsd
