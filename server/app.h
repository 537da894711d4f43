// The whole service: owns storage, worker and HTTP, and starts and stops them in the right order.
#pragma once

#include <memory>
#include <optional>

#include "server/base_map/base_map.h"
#include "server/config.h"
#include "server/http/http.h"
#include "server/jobs/jobs.h"
#include "server/sharing/sharing.h"

namespace freelsd {

class App {
 public:
  // Opens the data folder, reads the model and the page, binds the ports. Throws ConfigError,
  // StorageError or std::runtime_error with a message for the operator.
  explicit App(const Config& config);

  int port() const { return port_; }
  // Nothing if there is no emergency listener.
  std::optional<int> emergency_port() const { return emergency_port_; }
  // Serves until another thread calls Stop.
  void Run();
  // Ends the requests, then the worker. False if the engine is still busy after `patience`; the
  // next start repeats the unfinished work.
  bool Stop(std::chrono::milliseconds patience);
  // True if stored sites can be read from storage.
  bool CanRecall() const;

 private:
  SharingCalls CallsOfSharing();
  void BeginToFollow();

  Config config_;
  BaseMap base_map_;
  Storage storage_;
  EventLog events_;
  MapCache maps_;
  Intake intake_;
  Alternates alternates_;
  Service service_;
  HttpServer http_;
  int port_;
  std::unique_ptr<HttpServer> emergency_http_;
  std::optional<int> emergency_port_;
  // Empty if others work for this server.
  std::optional<Worker> worker_;
  // The last ones: their threads call the others.
  Sharing sharing_;
  std::unique_ptr<Follower> follower_;
};

}  // namespace freelsd
