// The HTTP library with our own handling of connections: heads are checked before the library sees
// them, bodies are read by the handlers, every error is a problem+json.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "server/body_reader.h"
#include "server/http_library.h"
#include "server/request_head.h"

namespace freelsd {

struct HttpOptions {
  HeadLimits head;
  std::vector<std::string> allowed_hosts;
  int num_threads = 32;
  // How long a head may take to come.
  std::chrono::milliseconds head_timeout{5000};
  // How long a thread waits for the next request of its connection.
  std::chrono::milliseconds idle_timeout{15000};
};

class HttpServer : public httplib::Server {
 public:
  using Handler =
      std::function<void(const httplib::Request&, BodyReader& body, httplib::Response&)>;

  // `handler` answers every request that has a valid head; it must not throw.
  HttpServer(const HttpOptions& options, Handler handler);

  // Port 0: any. Returns the port that was bound; throws std::runtime_error when it is taken.
  int Bind(const std::string& host, int port);
  // Serves until Stop, which may be called from another thread or by a signal's watcher.
  void Run();
  void Stop();

 private:
  bool process_and_close_socket(socket_t descriptor) override;
  // Whether the connection can be kept.
  bool ServeOne(const ClientSocket& socket, std::string& buffered, bool is_last);
  bool WaitForRequest(const ClientSocket& socket, const std::string& buffered) const;
  void Answer(const httplib::Request& request, httplib::Response& response) const;

  HttpOptions options_;
  Handler handler_;
  std::atomic<bool> is_stopping_{false};
};

// Sends what was written of the answer so far: for answers that go on. Only within a request; false
// where the client is gone.
bool FlushAnswer();

// Fills in a problem+json for this error.
void AnswerProblem(const class ApiError& error, httplib::Response& response);

}  // namespace freelsd
