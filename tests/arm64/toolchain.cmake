# 64-bit Arm, cross-compiled with Debian's clang against the packages that run_arm64.sh unpacked into
# HDRCAM_ARM64_ROOT. cmake -DCMAKE_TOOLCHAIN_FILE=.. -DHDRCAM_ARM64_ROOT=FOLDER
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
# clang, not gcc 12: gcc compares and converts the kernels' vectors of eight lane by lane where registers hold four.
set(CMAKE_CXX_COMPILER clang++)
set(CMAKE_CXX_COMPILER_TARGET aarch64-linux-gnu)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES HDRCAM_ARM64_ROOT)
set(CMAKE_SYSROOT ${HDRCAM_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH ${HDRCAM_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# Debian's OpenCV finds its linear algebra through alternatives, which only an installation sets.
set(linear_algebra "")
foreach(folder blas lapack)
  # quoted: the flags reach a shell as they are, and the folder may have a blank
  string(APPEND linear_algebra " \"-Wl,-rpath-link,${HDRCAM_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/${folder}\"")
endforeach()
set(CMAKE_EXE_LINKER_FLAGS_INIT "${linear_algebra}")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "${linear_algebra}")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "${linear_algebra}")
set(ENV{PKG_CONFIG_LIBDIR} ${HDRCAM_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${HDRCAM_ARM64_ROOT}/usr/share/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${HDRCAM_ARM64_ROOT})
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${HDRCAM_ARM64_ROOT})
