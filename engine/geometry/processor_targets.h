// Functions that are compiled for several instruction sets, one of which is chosen when the program
// starts. None of them fuses multiplications with additions, so that every processor has the same
// rounding.
#pragma once

// Sanitizers instrument the choice itself, before they are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FREELSD_SEVERAL_TARGETS __attribute__((target_clones("avx2", "default")))
#else
#define FREELSD_SEVERAL_TARGETS
#endif
