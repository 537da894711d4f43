// Private to stereo/. Registers of sixteen 16-bit or thirty-two 8-bit numbers, one in each lane.
#pragma once

#include <cstdint>

namespace freelsd {

constexpr int kNumLanes = 16;

typedef int16_t Shorts __attribute__((vector_size(32)));
typedef uint16_t UnsignedShorts __attribute__((vector_size(32)));
typedef uint8_t Bytes __attribute__((vector_size(32)));

template <typename Lanes, typename Value>
[[gnu::always_inline]] inline void Load(const Value* values, Lanes& lanes) {
  __builtin_memcpy(&lanes, values, sizeof(lanes));
}

template <typename Lanes, typename Value>
[[gnu::always_inline]] inline void Store(const Lanes& lanes, Value* values) {
  __builtin_memcpy(values, &lanes, sizeof(lanes));
}

// Sets every lane to the minimum of all lanes.
[[gnu::always_inline]] inline void SpreadLeast(Shorts& lanes) {
  Shorts other =
      __builtin_shufflevector(lanes, lanes, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
  lanes = lanes < other ? lanes : other;
  other =
      __builtin_shufflevector(lanes, lanes, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11);
  lanes = lanes < other ? lanes : other;
  other =
      __builtin_shufflevector(lanes, lanes, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
  lanes = lanes < other ? lanes : other;
  other =
      __builtin_shufflevector(lanes, lanes, 1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14);
  lanes = lanes < other ? lanes : other;
}

// Sum of the lanes. No lane may be negative, and the sum must fit into 16 bits.
[[gnu::always_inline]] inline int SumOf(const Shorts& lanes) {
  typedef uint64_t Longs __attribute__((vector_size(32)));
  constexpr uint64_t kEachOfFour = 0x0001000100010001;
  const auto fours = reinterpret_cast<Longs>(lanes);
  return static_cast<int>((fours[0] + fours[1] + fours[2] + fours[3]) * kEachOfFour >> 48);
}

// Sets `between` to the upper half of `lanes`, followed by the lower half of `after`.
[[gnu::always_inline]] inline void Join(const Shorts& lanes, const Shorts& after, Shorts& between) {
  between = __builtin_shufflevector(
      lanes, after, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23);
}

// OneBefore sets each lane of `shifted` to the number before that of the same lane in `lanes`.
// OneAfter sets it to the number after. For OneBefore, `between` is Join(previous register,
// `lanes`). For OneAfter, it is Join(`lanes`, next register).
[[gnu::always_inline]] inline void OneBefore(const Shorts& between,
                                             const Shorts& lanes,
                                             Shorts& shifted) {
  shifted = __builtin_shufflevector(
      between, lanes, 7, 16, 17, 18, 19, 20, 21, 22, 15, 24, 25, 26, 27, 28, 29, 30);
}

[[gnu::always_inline]] inline void OneAfter(const Shorts& lanes,
                                            const Shorts& between,
                                            Shorts& shifted) {
  shifted = __builtin_shufflevector(
      lanes, between, 1, 2, 3, 4, 5, 6, 7, 16, 9, 10, 11, 12, 13, 14, 15, 24);
}

}  // namespace freelsd
