// Compiles functions for several instruction sets; the program chooses one when it
// starts. None fuses multiplications with additions, so that every processor rounds
// alike.
#pragma once

// Sanitizers instrument the resolver, which runs before they are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FREELSD_SEVERAL_TARGETS __attribute__((target_clones("avx2", "default")))
#else
#define FREELSD_SEVERAL_TARGETS
#endif
