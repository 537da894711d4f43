// cpp-httplib's server with our own handling of connections. Heads are checked before the library
// parses them, handlers read the bodies, and every error is answered as problem+json.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "server/http/body_reader.h"
#include "server/http/http_library.h"
#include "server/http/request_head.h"

namespace freelsd {

// Limits of one listener.
struct HttpOptions {
  HeadLimits head;
  std::vector<std::string> allowed_hosts;
  int num_threads = 32;
  // How long a client may take to send a head.
  std::chrono::milliseconds head_timeout{5000};
  // How long a thread waits for the next request of its connection.
  std::chrono::milliseconds idle_timeout{15000};
};

class HttpServer : public httplib::Server {
 public:
  using Handler =
      std::function<void(const httplib::Request&, BodyReader& body, httplib::Response&)>;

  // `handler` answers every request that has a valid head. It must be thread-safe and not throw.
  HttpServer(const HttpOptions& options, Handler handler);

  // Port 0: any free port. Returns the bound port. Throws std::runtime_error if the port is taken.
  int Bind(const std::string& host, int port);
  // Serves until another thread calls Stop.
  void Run();
  void Stop();

 private:
  bool process_and_close_socket(socket_t descriptor) override;
  // True if the connection can be kept.
  bool ServeOne(const ClientSocket& socket, std::string& buffered, bool is_last);
  bool WaitForRequest(const ClientSocket& socket, const std::string& buffered) const;
  void Answer(const httplib::Request& request, httplib::Response& response) const;

  HttpOptions options_;
  Handler handler_;
  std::atomic<bool> is_stopping_{false};
};

// Sends the part of the answer that is written so far; for answers that continue as events happen.
// Call it only while serving a request. False if the client disconnected.
bool FlushAnswer();

// Fills the response with the error as problem+json.
void AnswerProblem(const class ApiError& error, httplib::Response& response);

}  // namespace freelsd
