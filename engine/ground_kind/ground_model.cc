#include <fstream>
#include <iterator>
#include <stdexcept>

#include "engine/ground_kind/ground_kind.h"

namespace freelsd {
namespace {

std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::invalid_argument(path.string() + " cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

GroundModelFile ReadGroundModel(const std::filesystem::path& file) {
  const std::string bytes = BytesOf(file);
  if (file.extension() != ".onnx") return {Classifier::Parse(bytes), bytes};
  const std::string card = BytesOf(std::filesystem::path(file).replace_extension(".json"));
  return {KindModel::Parse(bytes, card), bytes + card};
}

}  // namespace freelsd
