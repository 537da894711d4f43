// The head of an HTTP request, checked before anything else sees it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct HeadLimits {
  size_t max_bytes = 16 << 10;
  size_t max_num_lines = 64;
  size_t max_line_bytes = 4 << 10;
  size_t max_target_bytes = 2 << 10;
};

struct RequestHead {
  std::string method;
  std::string target;
  // Nothing: no body, unless chunked.
  std::optional<uint64_t> content_length;
  bool is_chunked = false;
  bool expects_continue = false;
  // The head again for the HTTP library: without what speaks of the body's transfer, of ranges and
  // of compression, which are not its business here.
  std::string forwarded;

  bool HasBody() const { return is_chunked || content_length.value_or(0) > 0; }
};

// `text` ends with the blank line. `allowed_hosts` in lower case, without port; loopback names are
// always allowed. Throws ApiError.
RequestHead ParseRequestHead(std::string_view text,
                             const HeadLimits& limits,
                             const std::vector<std::string>& allowed_hosts);

}  // namespace freelsd
