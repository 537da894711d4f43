// The real server on a free port with a fresh folder, and what tests send to it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/app.h"
#include "server/http/http_library.h"
#include "tests/storage/place.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {

// A small model trained on coloured noise; made once per process.
std::filesystem::path TestModel();
// Any port, this folder, the test model.
Config TestConfig(const std::filesystem::path& folder);

class TestServer {
 public:
  explicit TestServer(const Config& config);
  ~TestServer();
  TestServer(const TestServer&) = delete;
  TestServer& operator=(const TestServer&) = delete;

  int port() const { return app_.port(); }
  httplib::Client Client() const;
  // Of the emergency listener, which must be on.
  int emergency_port() const { return app_.emergency_port().value(); }
  httplib::Client EmergencyClient() const;

 private:
  App app_;
  std::thread thread_;
};

// A fresh folder with a server on it.
struct FreshServer {
  TemporaryFolder folder;
  TestServer server;
  httplib::Client client;
  explicit FreshServer(const std::function<void(Config&)>& change = {});
};

// Bytes over a plain socket, for what no client library sends.
class RawConnection {
 public:
  explicit RawConnection(int port);
  ~RawConnection();
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;
  void Send(const std::string& bytes) const;
  // One answer with a Content-Length: status line, headers and body. Empty when the server closes.
  std::string Receive();
  // Up to the blank line alone.
  std::string ReceiveHead() { return ReceiveUntil("\r\n\r\n"); }
  // Up to that text, and with it. Empty when the server closes, or sends nothing for ten seconds.
  std::string ReceiveUntil(const std::string& text);

 private:
  int descriptor_;
  std::string buffer_;
};

// Noise that no decoder confuses with another seed's.
std::string NoiseImage(int seed,
                       int width_px = 320,
                       int height_px = 240,
                       const char* type = ".jpg");
// POST /v1/flights with a camera of that size; its id.
std::string NewFlight(httplib::Client& client, int width_px = 320, int height_px = 240);
// A position near the others, attitude level.
std::string SomeMeta(int number = 0);
httplib::MultipartFormDataItems ImageAndMeta(const std::string& image, const std::string& meta);
httplib::Result PutFrame(httplib::Client& client,
                         const std::string& flight,
                         const std::string& frame,
                         const std::string& image,
                         const std::string& meta);
nlohmann::json FrameList(httplib::Client& client, const std::string& flight);
nlohmann::json GetJson(httplib::Client& client, const std::string& path);
// The job when it is over, or after five minutes: a machine may be busy.
nlohmann::json AwaitJob(httplib::Client& client, const std::string& job);
// Checks status, content type and code of a problem+json.
void CheckProblem(const httplib::Result& result, int status, const std::string& code);

}  // namespace freelsd
