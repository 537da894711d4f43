#include "storage/notices.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <unistd.h>

#include "storage/image_files.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

// The name of a file is '<raised_at_us>', and '<raised_at_us>-<acknowledged_at_us>' once it is
// acknowledged: to acknowledge, a full disk needs no room.
constexpr char kSpareName[] = "spare";
// The room of the spare file.
constexpr size_t kMaxBytes = 4096;

int64_t NowUs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

std::optional<Notice> NoticeNamed(const std::string& name) {
  Notice notice;
  const char* const end = name.data() + name.size();
  const auto raised = std::from_chars(name.data(), end, notice.raised_at_us);
  if (raised.ec != std::errc()) return std::nullopt;
  notice.id = std::string(name.data(), raised.ptr);
  if (raised.ptr == end) return notice;
  int64_t acknowledged_at_us = 0;
  const auto read = std::from_chars(raised.ptr + 1, end, acknowledged_at_us);
  if (*raised.ptr != '-' || read.ec != std::errc() || read.ptr != end) return std::nullopt;
  notice.acknowledged_at_us = acknowledged_at_us;
  return notice;
}

// Messages about a damaged database may hold bytes of it.
std::string Readable(std::string text) {
  for (char& each : text) {
    if (each < ' ' || each > '~') each = each == '\n' ? ' ' : '?';
  }
  return text.substr(0, kMaxBytes);
}

}  // namespace

NoticeBoard::NoticeBoard(const std::filesystem::path& folder,
                         std::function<void(const std::string&)> log)
    : folder_(folder), log_(std::move(log)) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw StorageError("create folder " + folder_.string(), error.message());
  Read();
  MakeSpare();
}

void NoticeBoard::Read() {
  for (const auto& file : std::filesystem::directory_iterator(folder_)) {
    std::optional<Notice> notice = NoticeNamed(file.path().filename().string());
    if (!notice) continue;
    std::ifstream stream(file.path(), std::ios::binary);
    notice->text = Readable(std::string(std::istreambuf_iterator<char>(stream), {}));
    raised_.push_back({std::move(*notice), true});
  }
  std::sort(raised_.begin(), raised_.end(), [](const Raised& a, const Raised& b) {
    return a.notice.raised_at_us < b.notice.raised_at_us;
  });
}

void NoticeBoard::MakeSpare() const {
  const int file = ::open((folder_ / kSpareName).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0640);
  if (file < 0) return;
  // Where this fails, a notice needs a disk that is not full.
  (void)::fallocate(file, FALLOC_FL_KEEP_SIZE, 0, kMaxBytes);
  ::close(file);
}

bool NoticeBoard::Write(const std::string& name, const std::string& text) const {
  const std::filesystem::path spare = folder_ / kSpareName;
  const int file = ::open(spare.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0640);
  if (file < 0) return false;
  const bool is_written =
      ::pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
      ::ftruncate(file, static_cast<off_t>(text.size())) == 0 && ::fsync(file) == 0;
  ::close(file);
  if (!is_written || ::rename(spare.c_str(), (folder_ / name).c_str()) != 0) return false;
  SyncFolder(folder_);
  MakeSpare();
  return true;
}

void NoticeBoard::Add(const std::string& text) { Raise(text, true); }

void NoticeBoard::AddForNow(const std::string& text) { Raise(text, false); }

void NoticeBoard::Raise(const std::string& text, bool is_lasting) {
  Notice notice;
  notice.text = Readable(text);
  {
    const std::lock_guard disk_lock(disk_mutex_);
    notice.raised_at_us = NowUs();
    for (const Raised& each : raised_) {
      notice.raised_at_us = std::max(notice.raised_at_us, each.notice.raised_at_us + 1);
    }
    notice.id = std::to_string(notice.raised_at_us);
    const bool is_on_disk = is_lasting && Write(notice.id, notice.text);
    const std::lock_guard lock(mutex_);
    raised_.push_back({notice, is_on_disk});
  }
  if (log_) log_(notice.text);
}

std::vector<Notice> NoticeBoard::List() const {
  const std::lock_guard lock(mutex_);
  std::vector<Notice> notices;
  notices.reserve(raised_.size());
  for (const Raised& each : raised_) notices.push_back(each.notice);
  return notices;
}

bool NoticeBoard::Acknowledge(const std::string& id) {
  const std::lock_guard disk_lock(disk_mutex_);
  const auto found = std::find_if(
      raised_.begin(), raised_.end(), [&id](const Raised& each) { return each.notice.id == id; });
  if (found == raised_.end()) return false;
  if (found->notice.acknowledged_at_us) return true;
  const int64_t now_us = NowUs();
  if (found->is_on_disk) {
    const std::string name = id + "-" + std::to_string(now_us);
    std::error_code error;
    std::filesystem::rename(folder_ / id, folder_ / name, error);
    if (error) throw StorageError("acknowledge a notice", error.message());
    SyncFolder(folder_);
  }
  const std::lock_guard lock(mutex_);
  found->notice.acknowledged_at_us = now_us;
  return true;
}

}  // namespace freelsd
