// What Storage's methods share: the write connection behind its mutex, and the readers' pool.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "storage/image_files.h"
#include "storage/sqlite.h"
#include "storage/storage.h"

namespace freelsd {

// Exclusive for this process while it lives.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// Read connections, as many as are used at once; each is given back at the end of its Reader.
class ReaderPool {
 public:
  explicit ReaderPool(const std::filesystem::path& database_file) : file_(database_file) {}
  std::unique_ptr<Connection> Take();
  void GiveBack(std::unique_ptr<Connection> connection);

 private:
  std::filesystem::path file_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;
};

class Reader {
 public:
  explicit Reader(ReaderPool& pool) : pool_(pool), connection_(pool.Take()) {}
  ~Reader() { pool_.GiveBack(std::move(connection_)); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  const Connection* operator->() const { return connection_.get(); }

 private:
  ReaderPool& pool_;
  std::unique_ptr<Connection> connection_;
};

struct Storage::State {
  explicit State(const std::filesystem::path& data_folder);

  std::filesystem::path folder;
  FolderLock lock;
  ImageFiles images;
  std::mutex write_mutex;
  Connection writer;
  ReaderPool readers;
};

}  // namespace freelsd
