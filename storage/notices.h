// What the operator must know, until it is acknowledged. Each lasting notice is a small file of its
// own, so that neither damage of a database nor a full disk takes it away.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct Notice {
  std::string id;
  // Sentences in ASCII.
  std::string text;
  int64_t raised_at_us = 0;
  std::optional<int64_t> acknowledged_at_us;
};

// Thread-safe.
class NoticeBoard {
 public:
  // `log` gets each notice once, when it is raised.
  NoticeBoard(const std::filesystem::path& folder, std::function<void(const std::string&)> log);

  // Stays until it is acknowledged, also after restarts. On disk when the call returns; if the disk
  // refuses it, it stays until the process ends.
  void Add(const std::string& text);
  // Stays until the process ends: a state that the next start ends, or finds again.
  void AddForNow(const std::string& text);
  // Oldest first, the acknowledged ones too.
  std::vector<Notice> List() const;
  // False if there is no such notice.
  bool Acknowledge(const std::string& id);

 private:
  struct Raised {
    Notice notice;
    bool is_on_disk = false;
  };
  void Read();
  // An empty file whose room is reserved, for a notice on a full disk.
  void MakeSpare() const;
  bool Write(const std::string& name, const std::string& text) const;
  void Raise(const std::string& text, bool is_lasting);

  std::filesystem::path folder_;
  std::function<void(const std::string&)> log_;
  // Guards the folder. Taken before mutex_, and by all who change raised_: who only reads waits for
  // no disk.
  std::mutex disk_mutex_;
  // Guards raised_.
  mutable std::mutex mutex_;
  std::vector<Raised> raised_;
};

}  // namespace freelsd
