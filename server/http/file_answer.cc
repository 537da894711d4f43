#include <fstream>
#include <memory>
#include <stdexcept>

#include "server/http/http_server.h"
#include "server/http/stamps.h"

namespace freelsd {
namespace {

constexpr size_t kMaxPieceBytes = size_t{256} << 10;
// The next piece is always there, so no heartbeat is ever due.
constexpr std::chrono::hours kNever{24};

LiveText NextPiece(std::ifstream& file) {
  LiveText piece;
  piece.text.resize(kMaxPieceBytes);
  file.read(piece.text.data(), static_cast<std::streamsize>(kMaxPieceBytes));
  piece.text.resize(static_cast<size_t>(file.gcount()));
  piece.is_over = !file;
  return piece;
}

}  // namespace

SpooledFile::SpooledFile(const std::filesystem::path& folder) : path_(folder / NewId("file")) {}

SpooledFile::~SpooledFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void AnswerFile(httplib::Response& response,
                const std::string& content_type,
                const std::filesystem::path& file) {
  auto opened = std::make_shared<std::ifstream>(file, std::ios::binary);
  if (!*opened) throw std::runtime_error("cannot read " + file.filename().string());
  const LiveText first = NextPiece(*opened);
  LiveAnswer rest;
  rest.next = [opened]() -> LiveText {
    if (!*opened) return {{}, true};
    return NextPiece(*opened);
  };
  rest.heartbeat_period = kNever;
  AnswerLive(response, content_type, first.text, std::move(rest));
}

}  // namespace freelsd
