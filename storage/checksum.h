// A checksum of a row's values, because SQLite's pages have no checksum.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace freelsd {

// 64-bit FNV-1a over the values, in the order in which they are added.
class Checksum {
 public:
  Checksum& Add(const std::string& text) {
    for (const char byte : text) AddByte(static_cast<unsigned char>(byte));
    return Add(static_cast<int64_t>(text.size()));
  }
  Checksum& Add(int64_t number) {
    for (int shift = 0; shift < 64; shift += 8) {
      AddByte(static_cast<unsigned char>(static_cast<uint64_t>(number) >> shift));
    }
    return *this;
  }
  // Adding 0.0 turns -0.0 into 0.0: SQLite does not keep the sign of zero.
  Checksum& Add(double number) { return Add(std::bit_cast<int64_t>(number + 0.0)); }
  int64_t value() const { return static_cast<int64_t>(hash_); }

 private:
  void AddByte(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3ull; }

  uint64_t hash_ = 0xcbf29ce484222325ull;
};

}  // namespace freelsd
