#include "server/http/http_server.h"

#include <algorithm>
#include <stdexcept>

#include <sys/socket.h>

#include "api/api.h"
#include "server/http/problem.h"

namespace freelsd {
namespace {

// This number is sent to clients. The poll loop does not enforce it.
constexpr int kMaxRequestsPerConnection = 10000;
// Most connections that wait to be accepted. The library's default of 5 refuses bursts.
constexpr int kListenBacklog = 1024;
constexpr size_t kWriteBufferBytes = 256 << 10;

// The request that this thread serves. A thread-local variable is needed, because the library
// passes no argument of ours to handlers.
thread_local BodyReader* body_of_this_thread = nullptr;
thread_local ClientConnection* connection_of_this_thread = nullptr;

// Sets both while a request is served.
class ServedRequest {
 public:
  ServedRequest(BodyReader& body, ClientConnection& connection) {
    body_of_this_thread = &body;
    connection_of_this_thread = &connection;
  }
  ~ServedRequest() {
    body_of_this_thread = nullptr;
    connection_of_this_thread = nullptr;
  }
  ServedRequest(const ServedRequest&) = delete;
  ServedRequest& operator=(const ServedRequest&) = delete;
};

// The stream from which the library reads a checked head, and to which it writes its answer. It
// never waits for the client: what the client does not take now stays in the connection's output.
class HeadStream : public httplib::Stream {
 public:
  HeadStream(ClientConnection& connection, const std::string& head)
      : connection_(connection), head_(head) {}

  bool is_readable() const override { return position_ < head_.size(); }
  bool is_writable() const override { return true; }
  ssize_t read(char* bytes, size_t size) override {
    const size_t num_taken = std::min(size, head_.size() - position_);
    head_.copy(bytes, num_taken, position_);
    position_ += num_taken;
    return static_cast<ssize_t>(num_taken);
  }
  ssize_t write(const char* bytes, size_t size) override {
    connection_.output.Append({bytes, size});
    if (connection_.output.size() <= kWriteBufferBytes) return static_cast<ssize_t>(size);
    return connection_.output.SendTo(connection_.socket) ? static_cast<ssize_t>(size) : -1;
  }
  using httplib::Stream::write;
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  socket_t socket() const override { return connection_.socket.descriptor(); }

 private:
  ClientConnection& connection_;
  const std::string& head_;
  size_t position_ = 0;
};

}  // namespace

HttpServer::HttpServer(const HttpOptions& options, Handler handler)
    : options_(options), handler_(std::move(handler)), loop_(options_.rules, options_.num_threads) {
  set_keep_alive_timeout(kLimits.connection.max_idle_s);
  set_keep_alive_max_count(kMaxRequestsPerConnection);
  // The library's default is SO_REUSEPORT, with which a second server could share the port.
  set_socket_options([](socket_t descriptor) {
    const int on = 1;
    ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  });
  set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    Answer(request, response);
    return HandlerResponse::Handled;
  });
  // The text of an unexpected exception never reaches a client.
  set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
        AnswerProblem(ApiError("InternalError", "the server failed"), response);
      });
  // Answers of the library itself.
  set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (!response.body.empty()) return;
    const std::string code = response.status == 404 ? "NotFound" : "InvalidRequest";
    response.set_content(ProblemJson(response.status, code, "the request is invalid"),
                         "application/problem+json");
  });
}

int HttpServer::Bind(const std::string& host, int port) {
  const int bound = port == 0 ? bind_to_any_port(host) : (bind_to_port(host, port) ? port : -1);
  if (bound <= 0) {
    throw std::runtime_error("cannot listen on " + host + ":" + std::to_string(port) +
                             ": the port is taken or the address is not this machine's");
  }
  listening_socket_ = std::make_unique<OwnDescriptor>(svr_sock_);
  ::listen(svr_sock_, kListenBacklog);
  return bound;
}

void HttpServer::Run() {
  httplib::ThreadPool threads(static_cast<size_t>(options_.num_threads));
  const int num_large =
      options_.rules.takes_large_bodies ? kLimits.connection.max_num_large_bodies : 0;
  httplib::ThreadPool large_bodies(static_cast<size_t>(num_large));
  loop_.Run(listening_socket_->value(), [&](ClientConnection& connection) {
    httplib::ThreadPool& pool = connection.has_large_body ? large_bodies : threads;
    pool.enqueue([this, &connection] { Serve(connection); });
  });
  threads.shutdown();
  large_bodies.shutdown();
}

void HttpServer::Stop() {
  is_stopping_ = true;
  loop_.Stop();
}

void HttpServer::Answer(const httplib::Request& request, httplib::Response& response) const {
  BodyReader& body = *body_of_this_thread;
  handler_(request, body, response);
  if (!body.SkipRest()) response.set_header("Connection", "close");
}

void HttpServer::Serve(ClientConnection& connection) {
  try {
    BodyReader body(connection.socket, connection.request.head(), connection.input);
    HeadStream stream(connection, connection.request.head().forwarded);
    const ServedRequest served(body, connection);
    bool is_closed = false;
    const bool is_whole = process_request(stream, is_stopping_, is_closed, nullptr);
    connection.is_last = is_closed || !is_whole || !body.IsAtEnd();
    connection.must_linger = !body.IsAtEnd();
    connection.has_next = !connection.input.empty() || connection.socket.HasBytes();
    // Sends what the client accepts at once, without waiting for the poll loop.
    connection.output.SendTo(connection.socket);
  } catch (const std::exception&) {
    // The process is probably out of memory. Only this connection ends.
    connection.is_last = true;
  }
  loop_.GiveBack(connection);
}

void AnswerLive(httplib::Response& response,
                const std::string& content_type,
                const std::string& begin,
                LiveAnswer rest) {
  connection_of_this_thread->live = std::move(rest);
  // The connection ends with the answer: a client that does not know would lose its next request.
  response.set_header("Connection", "close");
  // The library writes the head and the first chunk. The result false keeps it from ending the
  // answer.
  response.set_chunked_content_provider(content_type, [begin](size_t, httplib::DataSink& sink) {
    sink.write(begin.data(), begin.size());
    return false;
  });
}

}  // namespace freelsd
