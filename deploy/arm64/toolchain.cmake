# Builds for arm64 with Debian's cross compiler, against the Debian in FREELSD_SYSROOT or build/arm64-sysroot
# (deploy/arm64/sysroot.sh makes it). Programs that the build runs, tests among them, run under qemu's user mode.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

if(DEFINED ENV{FREELSD_SYSROOT})
  set(CMAKE_SYSROOT "$ENV{FREELSD_SYSROOT}")
else()
  file(REAL_PATH "${CMAKE_CURRENT_LIST_DIR}/../../build/arm64-sysroot" CMAKE_SYSROOT)
endif()
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${CMAKE_SYSROOT})
