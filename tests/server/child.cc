#include "tests/server/child.h"

#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

std::vector<std::string> ArgumentsOf(const ChildOptions& options) {
  std::vector<std::string> arguments{"freelsd-server",
                                     "--data",
                                     options.folder / "data",
                                     "--listen",
                                     options.listen,
                                     "--model",
                                     options.model};
  const StorageOptions storage = StorageAt(options.folder / "data");
  if (!storage.database_url.empty()) {
    arguments.insert(arguments.end(),
                     {"--database", storage.database_url, "--images", storage.images_folder});
  }
  arguments.insert(arguments.end(), options.more_arguments.begin(), options.more_arguments.end());
  return arguments;
}

// In the child: only what is safe after fork.
[[noreturn]] void Execute(const char* output, uint64_t max_file_bytes, char** arguments) {
  const int descriptor = ::open(output, O_CREAT | O_WRONLY | O_APPEND, 0600);
  ::dup2(descriptor, 1);
  ::dup2(descriptor, 2);
  if (max_file_bytes > 0) {
    // The signal is ignored so that the write itself fails; that survives exec.
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{max_file_bytes, max_file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ::execv(FREELSD_SERVER, arguments);
  ::_exit(127);
}

}  // namespace

Child::Child(const ChildOptions& options) : output_(options.folder / "output.txt") {
  std::vector<std::string> arguments = ArgumentsOf(options);
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  std::filesystem::remove(output_);
  process_ = ::fork();
  if (process_ == 0) Execute(output_.c_str(), options.max_file_bytes, pointers.data());
}

Child::~Child() {
  if (process_ > 0) Stop(SIGKILL);
}

int Child::AwaitPort(const std::string& key) const {
  for (int i = 0; i < 1000; ++i) {
    const std::string text = Output();
    const size_t at = text.find(key);
    if (at != std::string::npos) return std::stoi(text.substr(at + key.size()));
    ::usleep(10000);
  }
  FAIL("the server did not start: " << Output());
  return 0;
}

int Child::Wait() {
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

int Child::Stop(int signal) {
  ::kill(process_, signal);
  return Wait();
}

std::string Child::Output() const {
  std::ifstream file(output_);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

httplib::Client ClientOf(int port) {
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(30);
  HoldAgainstContract(client);
  return client;
}

}  // namespace freelsd
