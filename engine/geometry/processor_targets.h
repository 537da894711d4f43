// Compiles a function for several instruction sets; the program chooses one version when it starts.
// No version uses fused multiply-add, so every processor rounds alike.
#pragma once

// Switched off in builds with a sanitizer. The function that chooses the version runs before the
// sanitizer is initialised, but the sanitizer instruments it.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FREELSD_SEVERAL_TARGETS __attribute__((target_clones("avx2", "default")))
#else
#define FREELSD_SEVERAL_TARGETS
#endif
