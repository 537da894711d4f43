#include "server/http/connections/connection_table.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace freelsd {
namespace {

// Order in which connections are closed to make room. Nothing if the connection must not be closed.
std::optional<int> OrderOfClosing(ClientConnection::Phase phase) {
  using Phase = ClientConnection::Phase;
  switch (phase) {
    case Phase::kIdle:
      return 0;
    case Phase::kLingering:
      return 1;
    case Phase::kHead:
    case Phase::kBody:
      return 2;
    case Phase::kWriting:
      return 3;
    case Phase::kLive:
      return 4;
    case Phase::kServing:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

void ConnectionTable::Add(std::unique_ptr<ClientConnection> connection) {
  const int descriptor = connection->socket.descriptor();
  connections_[descriptor] = std::move(connection);
}

ClientConnection* ConnectionTable::Find(int descriptor) const {
  const auto found = connections_.find(descriptor);
  return found == connections_.end() ? nullptr : found->second.get();
}

void ConnectionTable::Close(const ClientConnection& connection) {
  connections_.erase(connection.socket.descriptor());
}

void ConnectionTable::Do(ClientConnection& connection,
                         const std::function<void(ClientConnection&)>& act) {
  const int descriptor = connection.socket.descriptor();
  try {
    act(connection);
  } catch (const std::exception&) {
    connections_.erase(descriptor);
  }
}

void ConnectionTable::ForEach(ClientConnection::Phase phase,
                              const std::function<void(ClientConnection&)>& act) {
  std::vector<ClientConnection*> chosen;
  for (const auto& [descriptor, connection] : connections_) {
    if (connection->phase == phase) chosen.push_back(connection.get());
  }
  for (ClientConnection* const connection : chosen) Do(*connection, act);
}

int ConnectionTable::CountLargeBodies() const {
  return static_cast<int>(
      std::count_if(connections_.begin(), connections_.end(), [](const auto& entry) {
        return entry.second->has_large_body;
      }));
}

bool ConnectionTable::CloseOne() {
  using Order = std::pair<int, SteadyTime>;
  const ClientConnection* first = nullptr;
  Order first_order;
  for (const auto& [descriptor, connection] : connections_) {
    const std::optional<int> of_phase = OrderOfClosing(connection->phase);
    if (!of_phase) continue;
    const Order order{*of_phase, connection->since};
    if (first != nullptr && order >= first_order) continue;
    first = connection.get();
    first_order = order;
  }
  if (first != nullptr) Close(*first);
  return first != nullptr;
}

void ConnectionTable::LimitUnsent(size_t max_bytes) {
  size_t total = 0;
  std::vector<const ClientConnection*> writing;
  for (const auto& [descriptor, connection] : connections_) {
    if (connection->phase != ClientConnection::Phase::kWriting) continue;
    total += connection->output.size();
    writing.push_back(connection.get());
  }
  std::sort(
      writing.begin(), writing.end(), [](const ClientConnection* a, const ClientConnection* b) {
        return a->since < b->since;
      });
  for (const ClientConnection* const connection : writing) {
    if (total <= max_bytes) return;
    total -= connection->output.size();
    Close(*connection);
  }
}

}  // namespace freelsd
