// The open connections of a listener. Chooses which of them are closed to make room. Only the
// thread of the poll loop uses this class.
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
  // nullptr if the connection is closed.
  ClientConnection* Find(int descriptor) const;
  void Close(const ClientConnection& connection);
  // Calls `act`, which may close the connection. If `act` throws, for example because memory is
  // short, the connection is closed.
  void Do(ClientConnection& connection, const std::function<void(ClientConnection&)>& act);
  // Calls Do for each connection in that phase.
  void ForEach(ClientConnection::Phase phase, const std::function<void(ClientConnection&)>& act);
  int CountLargeBodies() const;
  // Closes one connection to make room: idle ones first, then lingering ones, then those that
  // receive a request, a finished answer or live events. Of equals, closes the one that has waited
  // for longest. Never closes a connection whose request is being served. False if none can be
  // closed.
  bool CloseOne();
  // Limits the total size of unsent answers to max_bytes. Closes connections until the limit holds,
  // first those that have been reading their answer for longest.
  void LimitUnsent(size_t max_bytes);

 private:
  // By descriptor.
  std::unordered_map<int, std::unique_ptr<ClientConnection>> connections_;
};

}  // namespace freelsd
