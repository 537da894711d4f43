// An HTTP server with our own poll loop. cpp-httplib only parses requests and formats answers.
// Heads are checked before the library parses them. Requests reach a thread only when they are
// whole. Every error is answered as problem+json.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "server/http/body_reader.h"
#include "server/http/connections/connections.h"
#include "server/http/http_library.h"

namespace freelsd {

// Settings of one listener.
struct HttpOptions {
  RequestRules rules;
  // Threads for whole requests. Large bodies have threads of their own.
  int num_threads = 32;
};

class HttpServer : public httplib::Server {
 public:
  using Handler =
      std::function<void(const httplib::Request&, BodyReader& body, httplib::Response&)>;

  // `handler` answers every request that has a valid head. It must be thread-safe and not throw.
  HttpServer(const HttpOptions& options, Handler handler);

  // Port 0 means any free port. Returns the bound port. Throws std::runtime_error if the port is
  // taken or the address is not local.
  int Bind(const std::string& host, int port);
  // Serves until another thread calls Stop.
  void Run();
  void Stop();
  // Returns a function that makes this server ask all live answers for text. The function is
  // thread-safe and may outlive the server.
  std::function<void()> NewsCall() const { return loop_.NewsCall(); }

 private:
  void Serve(ClientConnection& connection);
  void Answer(const httplib::Request& request, httplib::Response& response) const;

  HttpOptions options_;
  Handler handler_;
  ConnectionLoop loop_;
  std::unique_ptr<OwnDescriptor> listening_socket_;
  std::atomic<bool> is_stopping_{false};
};

// Answers with a text that begins now and continues after the handler has returned. The poll loop
// sends the rest, so that the client holds no thread. Call it only while serving a request.
void AnswerLive(httplib::Response& response,
                const std::string& content_type,
                const std::string& begin,
                LiveAnswer rest);

// A file that is removed at the end. Its folder is SpoolFolder.
class SpooledFile {
 public:
  explicit SpooledFile(const std::filesystem::path& folder);
  ~SpooledFile();
  SpooledFile(const SpooledFile&) = delete;
  SpooledFile& operator=(const SpooledFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Sends the bytes that the file has now; it may be removed after this call. Uses memory for a small
// part of it. Call it only while serving a request. Throws std::runtime_error if the file cannot be
// read.
void AnswerFile(httplib::Response& response,
                const std::string& content_type,
                const std::filesystem::path& file);

}  // namespace freelsd
