#include "server/training/pools.h"

#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr const char* kHeader = "kind,name,pool";

// Throws std::invalid_argument unless the whole text is a number.
uint64_t ParseSeed(const std::string& text) {
  uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || last != end) throw std::invalid_argument(text + " is not a seed");
  return seed;
}

Pool PoolNamed(const std::string& name) {
  if (name == NameOf(Pool::kTuning)) return Pool::kTuning;
  if (name == NameOf(Pool::kReport)) return Pool::kReport;
  throw std::invalid_argument("no pool is named " + name);
}

int FoldNumbered(const std::string& text) {
  if (text.size() == 1 && text[0] >= '0' && text[0] <= '4') return text[0] - '0';
  throw std::invalid_argument("no fold is numbered " + text);
}

}  // namespace

const char* NameOf(Pool pool) { return pool == Pool::kTuning ? "tuning" : "report"; }

Pools Pools::Read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  Pools pools;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#' || line == kHeader) continue;
    std::istringstream cells(line);
    std::string kind, name, pool;
    std::getline(cells, kind, ',');
    std::getline(cells, name, ',');
    std::getline(cells, pool);
    try {
      if (kind == "fold") {
        pools.folds_[name] = FoldNumbered(pool);
      } else {
        pools.Add(kind, name, PoolNamed(pool));
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(path + ": cannot understand the line '" + line +
                               "': " + error.what());
    }
  }
  return pools;
}

void Pools::Add(const std::string& kind, const std::string& name, Pool pool) {
  if (kind != "seeds") {
    if (!pools_.try_emplace({kind, name}, pool).second) {
      throw std::invalid_argument(kind + " " + name + " is named twice");
    }
    return;
  }
  const size_t dots = name.find("..");
  if (dots == std::string::npos) throw std::invalid_argument(name + " is not a range");
  const std::string last = name.substr(dots + 2);
  seeds_.push_back({ParseSeed(name.substr(0, dots)),
                    last.empty() ? std::numeric_limits<uint64_t>::max() : ParseSeed(last),
                    pool});
}

std::optional<Pool> Pools::Of(const std::string& kind, const std::string& name) const {
  const auto found = pools_.find({kind, name});
  return found == pools_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<int> Pools::FoldOf(const std::string& name) const {
  const auto found = folds_.find(name);
  return found == folds_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<Pool> Pools::OfSeed(uint64_t seed) const {
  for (const SeedRange& range : seeds_) {
    if (seed >= range.first && seed <= range.last) return range.pool;
  }
  return std::nullopt;
}

std::vector<std::string> Pools::NamesOf(const std::string& kind, Pool pool) const {
  std::vector<std::string> names;
  for (const auto& [key, of] : pools_) {
    if (key.first == kind && of == pool) names.push_back(key.second);
  }
  return names;
}

void PoolOfRun::Add(const std::string& what, std::optional<Pool> pool) {
  if (!pool) return;
  if (!pool_) {
    pool_ = pool;
    first_ = what;
  }
  if (*pool_ == *pool) return;
  throw std::invalid_argument(what + " is of the pool " + NameOf(*pool) + ", but " + first_ +
                              " is of the pool " + NameOf(*pool_));
}

}  // namespace freelsd
