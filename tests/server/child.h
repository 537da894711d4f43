// The program itself as a child process, to be killed and started again.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/server/test_server.h"

namespace freelsd {

struct ChildOptions {
  // Holds the data folder and what the program says.
  std::filesystem::path folder;
  std::filesystem::path model = TestModel();
  std::string listen = "127.0.0.1:0";
  // Files may not grow beyond it: what writes more fails as on a full disk.
  uint64_t max_file_bytes = 0;
  std::vector<std::string> more_arguments{};
};

// Killed at the end if it still runs.
class Child {
 public:
  explicit Child(const ChildOptions& options);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The port it says it listens on, behind this text.
  int AwaitPort(const std::string& key = "listens on http://127.0.0.1:") const;
  // Exit code, or minus the signal.
  int Wait();
  int Stop(int signal);
  std::string Output() const;

 private:
  std::filesystem::path output_;
  pid_t process_ = -1;
};

httplib::Client ClientOf(int port);

}  // namespace freelsd
