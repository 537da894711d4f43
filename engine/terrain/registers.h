// Private to terrain/. SIMD registers of several numbers, one per lane. An operation applies to all
// lanes at once and rounds alike on every processor.
#pragma once

#include <cstddef>

namespace freelsd {

template <size_t num_lanes>
struct Register {
  typedef double Doubles __attribute__((vector_size(num_lanes * sizeof(double))));
  typedef float Floats __attribute__((vector_size(num_lanes * sizeof(float))));
  typedef int Ints __attribute__((vector_size(num_lanes * sizeof(int))));
};

// Converts lane by lane, because compilers optimise this better than a conversion of the whole
// register.
template <typename To, typename From>
[[gnu::always_inline]] inline void Convert(const From& from, To& to) {
  for (size_t lane = 0; lane < sizeof(To) / sizeof(to[0]); ++lane) to[lane] = from[lane];
}

template <typename Lanes, typename Value>
[[gnu::always_inline]] inline void Load(const Value* values, Lanes& lanes) {
  __builtin_memcpy(&lanes, values, sizeof(lanes));
}

template <typename Lanes, typename Value>
[[gnu::always_inline]] inline void Store(const Lanes& lanes, Value* values) {
  __builtin_memcpy(values, &lanes, sizeof(lanes));
}

}  // namespace freelsd
