// The whole service: storage, worker and HTTP, made and ended in the right order.
#pragma once

#include <memory>
#include <optional>

#include "server/config.h"
#include "server/http_server.h"
#include "server/service.h"
#include "server/worker.h"

namespace freelsd {

class App {
 public:
  // Opens the folder, reads model and page, binds the port. Throws ConfigError, StorageError or
  // std::runtime_error with a sentence for the operator.
  explicit App(const Config& config);

  int port() const { return port_; }
  // Nothing without an emergency listener.
  std::optional<int> emergency_port() const { return emergency_port_; }
  // Serves until Stop, from another thread.
  void Run();
  // Requests end, then the worker. False when the engine is still busy after `patience`: what it
  // was doing is done again at the next start.
  bool Stop(std::chrono::milliseconds patience);
  // Whether stored sites can be read: what this service must never lose.
  bool CanRecall() const;

 private:
  Config config_;
  Storage storage_;
  Service service_;
  HttpServer http_;
  int port_;
  std::unique_ptr<HttpServer> emergency_http_;
  std::optional<int> emergency_port_;
  Worker worker_;
};

}  // namespace freelsd
