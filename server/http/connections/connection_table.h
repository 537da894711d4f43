// The open connections of a listener. Chooses which of them are closed to make room. Only the
// thread of the poll loop uses this class.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
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
  // The queued connection whose request is served next: the longest waiting, pipelined ones last.
  // nullptr if there is none, if `max_num_served` are being served, or if it is pipelined and
  // another pipelined one is being served. Large bodies do not count.
  ClientConnection* NextToServe(int max_num_served) const;
  // Closes one connection if all are as many as the limits allow, or those of this peer. Closes one
  // of this peer in the latter case, else one of a peer that has the most. False if none can be
  // closed.
  bool MakeRoomFor(const std::string& peer);
  // Closes one connection: idle and lingering ones first, then queued requests that are pipelined,
  // slow readers, those that receive a request or are new, live events, and other queued requests.
  // Of equals, closes the one that has waited for longest. Never closes a connection whose request
  // is being served. False if none can be closed.
  bool CloseOne();
  // Limits the total size of unsent answers to max_bytes. Closes connections until the limit holds,
  // first those that have been reading their answer for longest.
  void LimitUnsent(size_t max_bytes);

 private:
  using Test = std::function<bool(const ClientConnection&)>;

  bool CloseOneOf(const Test& is_meant);
  size_t CountOf(const std::string& peer) const;
  void Erase(int descriptor);

  // By descriptor.
  std::unordered_map<int, std::unique_ptr<ClientConnection>> connections_;
  // Number of connections, by peer.
  std::map<std::string, size_t> counts_;
};

}  // namespace freelsd
