// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file failing_allocations.h
/// Memory that runs out on purpose: replaces operator new of the program. Include it in one
/// source file of a test program.

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace superray::test {

/// Allocations fail once `allowed` of them have succeeded.
struct FailingAllocations {
    std::atomic<int> allowed{-1};  ///< -1: no limit
    std::atomic<int> asked{0};
    std::atomic<std::size_t> freed{0};

    void refuseSome() {
        ++asked;
        if (allowed < 0 || allowed.fetch_sub(1) > 0) return;
        allowed = 0;
        throw std::bad_alloc();
    }
};
inline FailingAllocations allocations;

}  // namespace superray::test

[[gnu::noinline]] void* operator new(std::size_t bytes) {
    superray::test::allocations.refuseSome();
    if (void* const p = std::malloc(bytes)) return p;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
    ++superray::test::allocations.freed;
    std::free(p);
}
[[gnu::noinline]] void* operator new(std::size_t bytes, std::align_val_t alignment) {
    superray::test::allocations.refuseSome();
    const auto a = static_cast<std::size_t>(alignment);
    if (void* const p = std::aligned_alloc(a, (bytes + a - 1) / a * a)) return p;
    throw std::bad_alloc();
}
void operator delete(void* p, std::align_val_t) noexcept {
    operator delete(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    operator delete(p);
}
// Sanitizers have their own of these.
void* operator new[](std::size_t bytes) {
    return operator new(bytes);
}
void operator delete[](void* p) noexcept {
    operator delete(p);
}
void operator delete(void* p, std::size_t) noexcept {
    operator delete(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    operator delete(p);
}
