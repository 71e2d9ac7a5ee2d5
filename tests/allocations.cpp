#include "tests/allocations.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>

// A sanitizer brings operators of its own; a build with one counts nothing.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
#define HDRCAM_OPERATORS_ARE_TAKEN
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer) || __has_feature(address_sanitizer)
#define HDRCAM_OPERATORS_ARE_TAKEN
#endif
#endif

extern "C" const char __executable_start, etext;  // of the linker: where this program's own code lies

namespace {

constexpr std::size_t kNoneIsRefused = std::numeric_limits<std::size_t>::max();

std::atomic<std::uint64_t> allocations{0}, own_allocations{0};
thread_local std::size_t refused_from_bytes = kNoneIsRefused;

bool is_own_code(const void* address) { return address >= &__executable_start && address < &etext; }

// caller: the address to which operator new returns.
[[maybe_unused]] void* allocate(std::size_t size, std::size_t alignment, const void* caller) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (is_own_code(caller)) own_allocations.fetch_add(1, std::memory_order_relaxed);
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  if (size >= refused_from_bytes) throw std::bad_alloc();
  void* memory = std::aligned_alloc(alignment, whole == 0 ? alignment : whole);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

[[maybe_unused]] void* allocate_or_null(std::size_t size, std::size_t alignment,
                                        const void* caller) noexcept {
  try {
    return allocate(size, alignment, caller);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

#ifndef HDRCAM_OPERATORS_ARE_TAKEN
void* operator new(std::size_t size) {
  return allocate(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__, __builtin_return_address(0));
}
// The array forms would call the plain one from within the C++ library, and hide their caller.
void* operator new[](std::size_t size) {
  return allocate(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__, __builtin_return_address(0));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate_or_null(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__, __builtin_return_address(0));
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(size, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
#endif

namespace hdrcam {

std::uint64_t allocations_so_far() { return allocations.load(std::memory_order_relaxed); }

bool allocations_are_counted() {
#ifdef HDRCAM_OPERATORS_ARE_TAKEN
  return false;
#else
  return true;
#endif
}

std::uint64_t own_allocations_so_far() { return own_allocations.load(std::memory_order_relaxed); }

EndOfMemory::EndOfMemory(std::size_t refused_bytes) { refused_from_bytes = refused_bytes; }

EndOfMemory::~EndOfMemory() { refused_from_bytes = kNoneIsRefused; }

}  // namespace hdrcam
