// Input: a table of names. Output: which pool each flight, place and seed belongs to. The pool
// "tuning" may train models and set options; the pool "report" only judges a frozen engine.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace freelsd {

enum class Pool { kTuning, kReport };
const char* NameOf(Pool pool);  // "tuning", "report"

class Pools {
 public:
  // Reads lines `kind,name,pool`. The name of the kind "seeds" is a range, FIRST..LAST or FIRST..
  // A line of the kind "fold" has a number from 0 to 4 in place of the pool.
  // Throws std::runtime_error that names the file and the line that cannot be read.
  static Pools Read(const std::string& path);

  // Empty if the table does not name it: data of the user's own.
  std::optional<Pool> Of(const std::string& kind, const std::string& name) const;
  std::optional<Pool> OfSeed(uint64_t seed) const;
  // Of flights and places: the number of the model that learned from all places but those of its
  // fold. Empty if the table does not say.
  std::optional<int> FoldOf(const std::string& name) const;
  // In alphabetical order.
  std::vector<std::string> NamesOf(const std::string& kind, Pool pool) const;

 private:
  struct SeedRange {
    uint64_t first = 0;
    uint64_t last = 0;
    Pool pool = Pool::kTuning;
  };
  void Add(const std::string& kind, const std::string& name, Pool pool);

  std::map<std::pair<std::string, std::string>, Pool> pools_;
  std::vector<SeedRange> seeds_;
  std::map<std::string, int> folds_;
};

// The pool of everything that one run uses. Throws std::invalid_argument if a second pool is added:
// "seed 50000 is of the pool report, but ground churo_pe is of the pool tuning".
class PoolOfRun {
 public:
  // Without a pool nothing changes.
  void Add(const std::string& what, std::optional<Pool> pool);
  const std::optional<Pool>& pool() const { return pool_; }

 private:
  std::optional<Pool> pool_;
  std::string first_;
};

}  // namespace freelsd
