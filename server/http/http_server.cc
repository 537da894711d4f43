#include "server/http/http_server.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <sys/socket.h>

#include "api/api.h"

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kStopPollPeriod{200};
constexpr int kMaxRequestsPerConnection = 10000;
// Most connections that wait to be accepted. The library's default of 5 refuses bursts.
constexpr int kListenBacklog = 1024;
constexpr size_t kWriteBufferBytes = 256 << 10;

// Body of the request that this thread serves. The library passes no argument of ours to handlers.
thread_local BodyReader* body_of_this_thread = nullptr;

// The stream from which the library reads a checked head, and to which it writes its answer.
class HeadStream : public httplib::Stream {
 public:
  HeadStream(const ClientSocket& socket, std::string head)
      : socket_(socket), head_(std::move(head)) {}

  bool is_readable() const override { return position_ < head_.size(); }
  bool is_writable() const override { return !is_broken_; }
  ssize_t read(char* bytes, size_t size) override {
    const size_t num_taken = std::min(size, head_.size() - position_);
    head_.copy(bytes, num_taken, position_);
    position_ += num_taken;
    return static_cast<ssize_t>(num_taken);
  }
  ssize_t write(const char* bytes, size_t size) override {
    answer_.append(bytes, size);
    if (answer_.size() > kWriteBufferBytes) Flush();
    return is_broken_ ? -1 : static_cast<ssize_t>(size);
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
  socket_t socket() const override { return socket_.descriptor(); }

  // True if everything was sent.
  bool Flush() {
    is_broken_ = is_broken_ || !socket_.Write(answer_);
    answer_.clear();
    return !is_broken_;
  }

 private:
  const ClientSocket& socket_;
  std::string head_;
  size_t position_ = 0;
  std::string answer_;
  bool is_broken_ = false;
};

thread_local HeadStream* stream_of_this_thread = nullptr;

// The whole answer with a problem+json, for requests that never reach the library.
std::string RawProblem(const ApiError& error) {
  const std::string body = ProblemJson(error);
  std::string allow;
  if (error.http_status() == 405) allow = "Allow: GET, HEAD, POST, PUT, DELETE\r\n";
  return "HTTP/1.1 " + std::to_string(error.http_status()) + " " + error.code() +
         "\r\nContent-Type: application/problem+json\r\nConnection: close\r\n" + allow +
         "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

// Takes a head, blank line included, out of `buffered`. Nothing if the client ends or sends
// nothing. Throws ApiError if the head is too large or arrives too slowly.
std::optional<std::string> ReadHead(const ClientSocket& socket,
                                    std::string& buffered,
                                    const HeadLimits& limits,
                                    SteadyTime deadline) {
  std::array<char, 4096> bytes;
  size_t end = 0;
  while ((end = buffered.find("\r\n\r\n")) == std::string::npos) {
    if (buffered.size() > limits.max_bytes) {
      throw buffered.find("\r\n") == std::string::npos
          ? ApiError("UriTooLong", "the request line does not end")
          : ApiError("HeadersTooLarge",
                     "the head is larger than " + std::to_string(limits.max_bytes) + " bytes");
    }
    const size_t num_read = socket.Read(bytes.data(), bytes.size(), deadline);
    if (num_read == 0 && buffered.empty()) return std::nullopt;
    if (num_read == 0) throw ApiError("RequestTimeout", "the head did not arrive in time");
    buffered.append(bytes.data(), num_read);
    // Blank lines before a request are allowed (RFC 9112, 2.2).
    while (buffered.starts_with("\r\n")) buffered.erase(0, 2);
  }
  std::string head = buffered.substr(0, end + 4);
  buffered.erase(0, end + 4);
  if (head.size() > limits.max_bytes) {
    throw ApiError("HeadersTooLarge",
                   "the head is larger than " + std::to_string(limits.max_bytes) + " bytes");
  }
  return head;
}

}  // namespace

void AnswerProblem(const ApiError& error, httplib::Response& response) {
  response.status = error.http_status();
  response.set_content(ProblemJson(error), "application/problem+json");
  if (const std::optional<int> seconds = RetryAfterSeconds(error.code())) {
    response.set_header("Retry-After", std::to_string(*seconds));
  }
  if (error.http_status() == 401) response.set_header("WWW-Authenticate", "Bearer");
}

HttpServer::HttpServer(const HttpOptions& options, Handler handler)
    : options_(options), handler_(std::move(handler)) {
  new_task_queue = [num_threads = options.num_threads] {
    return new httplib::ThreadPool(static_cast<size_t>(num_threads));
  };
  set_tcp_nodelay(true);
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
  ::listen(svr_sock_, kListenBacklog);
  return bound;
}

bool FlushAnswer() { return stream_of_this_thread->Flush(); }

void HttpServer::Run() { listen_after_bind(); }

void HttpServer::Stop() {
  is_stopping_ = true;
  stop();
}

void HttpServer::Answer(const httplib::Request& request, httplib::Response& response) const {
  BodyReader& body = *body_of_this_thread;
  handler_(request, body, response);
  if (!body.SkipRest()) response.set_header("Connection", "close");
}

bool HttpServer::WaitForRequest(const ClientSocket& socket, const std::string& buffered) const {
  const SteadyTime deadline = std::chrono::steady_clock::now() + options_.idle_timeout;
  while (buffered.empty() && !is_stopping_ && std::chrono::steady_clock::now() < deadline) {
    if (socket.IsReadableBefore(std::chrono::steady_clock::now() + kStopPollPeriod)) return true;
  }
  return !buffered.empty();
}

bool HttpServer::ServeOne(const ClientSocket& socket, std::string& buffered, bool is_last) {
  try {
    const SteadyTime deadline = std::chrono::steady_clock::now() + options_.head_timeout;
    const std::optional<std::string> text = ReadHead(socket, buffered, options_.head, deadline);
    if (!text) return false;
    const RequestHead head = ParseRequestHead(*text, options_.head, options_.allowed_hosts);
    BodyReader body(socket, head, buffered);
    HeadStream stream(socket, head.forwarded);
    body_of_this_thread = &body;
    stream_of_this_thread = &stream;
    bool is_closed = false;
    const bool is_written =
        process_request(stream, is_last || is_stopping_, is_closed, nullptr) && stream.Flush();
    body_of_this_thread = nullptr;
    stream_of_this_thread = nullptr;
    if (!body.IsAtEnd()) {
      socket.Linger();
      return false;
    }
    return is_written && !is_closed;
  } catch (const ApiError& error) {
    socket.Write(RawProblem(error));
    socket.Linger();
    return false;
  } catch (const std::exception&) {
    // Most likely out of memory: only this connection ends.
    return false;
  }
}

bool HttpServer::process_and_close_socket(socket_t descriptor) {
  const ClientSocket socket(descriptor);
  std::string buffered;
  for (int i = 1; i <= kMaxRequestsPerConnection && WaitForRequest(socket, buffered); ++i) {
    if (!ServeOne(socket, buffered, i == kMaxRequestsPerConnection)) break;
  }
  return true;
}

}  // namespace freelsd
