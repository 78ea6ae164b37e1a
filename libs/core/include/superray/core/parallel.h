#pragma once
/// \file parallel.h
/// Work in several threads.

#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace superray {

/// First of `n` things that belong to a share, of `shares` about equal ones.
inline std::size_t shareBegin(std::size_t n, std::size_t share, std::size_t shares) {
    return n * share / shares;
}

/// Runs work(share) for the shares 0 .. shares-1, the first in this thread.
/// \throws the first exception of any of them, when all have ended
template <typename Work>
void inParallel(std::size_t shares, const Work& work) {
    if (shares == 1) return work(std::size_t{0});
    std::vector<std::exception_ptr> failures(shares);
    const auto guarded = [&](std::size_t s) {
        try {
            work(s);
        } catch (...) {
            failures[s] = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    threads.reserve(shares);
    for (std::size_t s = 1; s < shares; ++s) threads.emplace_back(guarded, s);
    guarded(0);
    for (std::thread& t : threads) t.join();
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace superray
