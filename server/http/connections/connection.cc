#include "server/http/connections/connection.h"

namespace freelsd {

bool UnsentBytes::SendTo(const ClientSocket& socket) {
  while (!empty()) {
    const auto num_sent = socket.WriteNow(std::string_view(bytes_).substr(num_sent_));
    if (!num_sent) return false;
    if (*num_sent == 0) return true;
    num_sent_ += *num_sent;
  }
  // Frees the memory, too: a connection may be idle for long.
  bytes_ = std::string();
  num_sent_ = 0;
  return true;
}

}  // namespace freelsd
