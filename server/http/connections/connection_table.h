// The open connections of a listener, and which of them are closed to make room. Only the poll
// loop's thread uses it.
#pragma once

#include <functional>
#include <memory>
#include <unordered_map>

#include "server/http/connections/connection.h"

namespace freelsd {

class ConnectionTable {
 public:
  bool empty() const { return connections_.empty(); }
  size_t size() const { return connections_.size(); }
  void Add(std::unique_ptr<ClientConnection> connection);
  // nullptr if it is closed.
  ClientConnection* Find(int descriptor) const;
  void Close(const ClientConnection& connection);
  // Calls `act`, which may close the connection. If it fails, for example because memory is short,
  // the connection is closed.
  void Do(ClientConnection& connection, const std::function<void(ClientConnection&)>& act);
  // The same for each connection of that phase.
  void ForEach(ClientConnection::Phase phase, const std::function<void(ClientConnection&)>& act);
  int CountLargeBodies() const;
  // Closes the connection that is missed least: the longest idle one. Connections that are being
  // served stay. False if there is none to close.
  bool CloseOne();
  // Closes connections that have read their answers for longest, until the rest of all answers has
  // at most that many bytes.
  void LimitUnsent(size_t max_bytes);

 private:
  // By descriptor.
  std::unordered_map<int, std::unique_ptr<ClientConnection>> connections_;
};

}  // namespace freelsd
