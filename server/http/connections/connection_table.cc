#include "server/http/connections/connection_table.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "api/api.h"

namespace freelsd {
namespace {

// A connection without a request counts as idle after this time. A client that has just connected
// must have the time to send one.
constexpr std::chrono::milliseconds kGraceOfIdle{500};
// One thread for the clients that do not wait for answers: the others serve those that do.
constexpr int kMaxNumPipelinedServed = 1;

// Order in which connections are closed to make room. Nothing if the connection must not be closed.
std::optional<int> OrderOfClosing(const ClientConnection& connection, SteadyTime now) {
  using Phase = ClientConnection::Phase;
  switch (connection.phase) {
    case Phase::kIdle:
      return now - connection.since >= kGraceOfIdle ? 0 : 3;
    case Phase::kLingering:
      return 0;
    case Phase::kQueued:
      return connection.is_pipelined ? 1 : 5;
    case Phase::kWriting:
      return 2;
    case Phase::kHead:
    case Phase::kBody:
      return 3;
    case Phase::kLive:
      return 4;
    case Phase::kServing:
      return std::nullopt;
  }
  return std::nullopt;
}

bool IsServedBefore(const ClientConnection& a, const ClientConnection& b) {
  return std::pair(a.is_pipelined, a.since) < std::pair(b.is_pipelined, b.since);
}

}  // namespace

void ConnectionTable::Add(std::unique_ptr<ClientConnection> connection) {
  const int descriptor = connection->socket.descriptor();
  ++counts_[connection->peer];
  connections_[descriptor] = std::move(connection);
}

ClientConnection* ConnectionTable::Find(int descriptor) const {
  const auto found = connections_.find(descriptor);
  return found == connections_.end() ? nullptr : found->second.get();
}

void ConnectionTable::Close(const ClientConnection& connection) {
  Erase(connection.socket.descriptor());
}

void ConnectionTable::Erase(int descriptor) {
  const auto found = connections_.find(descriptor);
  if (found == connections_.end()) return;
  const auto count = counts_.find(found->second->peer);
  if (--count->second == 0) counts_.erase(count);
  connections_.erase(found);
}

void ConnectionTable::Do(ClientConnection& connection,
                         const std::function<void(ClientConnection&)>& act) {
  const int descriptor = connection.socket.descriptor();
  try {
    act(connection);
  } catch (const std::exception&) {
    Erase(descriptor);
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

ClientConnection* ConnectionTable::NextToServe(int max_num_served) const {
  int num_served = 0, num_pipelined = 0;
  ClientConnection* next = nullptr;
  for (const auto& [descriptor, connection] : connections_) {
    if (connection->phase == ClientConnection::Phase::kServing && !connection->has_large_body) {
      ++num_served;
      num_pipelined += connection->is_pipelined ? 1 : 0;
    }
    if (connection->phase != ClientConnection::Phase::kQueued) continue;
    if (next == nullptr || IsServedBefore(*connection, *next)) next = connection.get();
  }
  if (next == nullptr || num_served >= max_num_served) return nullptr;
  return next->is_pipelined && num_pipelined >= kMaxNumPipelinedServed ? nullptr : next;
}

size_t ConnectionTable::CountOf(const std::string& peer) const {
  const auto found = counts_.find(peer);
  return found == counts_.end() ? 0 : found->second;
}

bool ConnectionTable::MakeRoomFor(const std::string& peer) {
  if (CountOf(peer) >= kLimits.connection.max_num_connections_of_address) {
    return CloseOneOf([&peer](const ClientConnection& each) { return each.peer == peer; });
  }
  if (size() < kLimits.connection.max_num_connections) return true;
  size_t most = 0;
  for (const auto& [each, count] : counts_) most = std::max(most, count);
  return CloseOneOf([&](const ClientConnection& each) { return CountOf(each.peer) == most; }) ||
         CloseOne();
}

bool ConnectionTable::CloseOne() {
  return CloseOneOf([](const ClientConnection&) { return true; });
}

bool ConnectionTable::CloseOneOf(const Test& is_meant) {
  using Order = std::pair<int, SteadyTime>;
  const SteadyTime now = std::chrono::steady_clock::now();
  const ClientConnection* first = nullptr;
  Order first_order;
  for (const auto& [descriptor, connection] : connections_) {
    const std::optional<int> of_phase = OrderOfClosing(*connection, now);
    if (!of_phase || !is_meant(*connection)) continue;
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
