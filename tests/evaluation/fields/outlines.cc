#include "tests/evaluation/fields/outlines.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace freelsd {
namespace {

// In the order of OutlineKind.
constexpr std::array<const char*, kNumOutlineKinds> kNames{"land",
                                                           "refuse",
                                                           "doubt",
                                                           "wall",
                                                           "fence",
                                                           "stream",
                                                           "tree",
                                                           "hedge",
                                                           "road",
                                                           "person",
                                                           "vehicle",
                                                           "building",
                                                           "pole",
                                                           "boulder"};

std::optional<OutlineKind> KindNamed(const std::string& name) {
  for (size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i]) return static_cast<OutlineKind>(i);
  }
  return std::nullopt;
}

double NumberIn(const std::string& word) {
  std::istringstream stream(word);
  double value = 0.0;
  if (!(stream >> value) || !stream.eof() || !std::isfinite(value)) {
    throw std::runtime_error("\"" + word + "\" is not a number");
  }
  return value;
}

// Throws without the place of the line.
Outline OutlineOf(const std::vector<std::string>& words) {
  constexpr size_t kNumHeadWords = 4, kMinNumWords = kNumHeadWords + 4;
  if (words.size() < kMinNumWords) {
    throw std::runtime_error("expected ID KIND PHOTOGRAPH HEIGHT_M and at least two corners");
  }
  if (words.size() % 2 != 0) throw std::runtime_error("the last corner has no row");
  const std::optional<OutlineKind> kind = KindNamed(words[1]);
  if (!kind) throw std::runtime_error("\"" + words[1] + "\" is not a kind");
  Outline outline{words[0], *kind, words[2], NumberIn(words[3]), {}};
  if (outline.height_m < 0.0) throw std::runtime_error("the height is negative");
  for (size_t i = kNumHeadWords; i < words.size(); i += 2) {
    outline.corners_in_image.emplace_back(NumberIn(words[i]), NumberIn(words[i + 1]));
  }
  if (IsGround(*kind) && outline.corners_in_image.size() < 3) {
    throw std::runtime_error("ground needs at least three corners");
  }
  return outline;
}

std::vector<std::string> WordsOf(const std::string& line) {
  std::istringstream stream(line.substr(0, line.find('#')));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

const char* NameOf(OutlineKind kind) { return kNames[static_cast<size_t>(kind)]; }

bool IsGround(OutlineKind kind) {
  return kind == OutlineKind::kLand || kind == OutlineKind::kRefuse || kind == OutlineKind::kDoubt;
}

bool IsThin(OutlineKind kind) { return kind == OutlineKind::kFence || kind == OutlineKind::kPole; }

std::vector<Outline> ParseOutlines(std::string_view text, const std::string& name) {
  std::istringstream stream{std::string(text)};
  std::vector<Outline> outlines;
  std::map<std::string, OutlineKind> kinds;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string> words = WordsOf(line);
    if (words.empty()) continue;
    try {
      outlines.push_back(OutlineOf(words));
      const Outline& last = outlines.back();
      if (kinds.emplace(last.id, last.kind).first->second != last.kind) {
        throw std::runtime_error(last.id + " has another kind above");
      }
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(name + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return outlines;
}

}  // namespace freelsd
