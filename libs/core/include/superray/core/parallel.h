#pragma once
/// \file parallel.h
/// Work in several threads.

#include <algorithm>
#include <cstddef>
#include <functional>

namespace superray {

/// First of `n` things that belong to a share, of `shares` about equal ones.
inline std::size_t shareBegin(std::size_t n, std::size_t share, std::size_t shares) {
    return n * share / shares;
}

/// How many shares `n` things are worth, if `perShare` of them repay a thread: at least 1,
/// at most `threads`. \pre threads > 0
inline std::size_t shareCountFor(std::size_t n, std::size_t perShare, std::size_t threads) {
    return std::max<std::size_t>(1, std::min(threads, n / perShare));
}

/// As inParallel(), for two shares or more.
void inThreads(std::size_t shares, const std::function<void(std::size_t)>& work);

/// Runs work(share) for the shares 0 .. shares-1, in this thread and in others that the
/// process keeps for that: as many at once as the machine has processors, so a share must
/// not wait for one that has not begun. A single share is like a call of work(0).
/// \throws the exception of the first share that failed, when all have ended
template <typename Work>
void inParallel(std::size_t shares, const Work& work) {
    if (shares == 1) return work(std::size_t{0});
    inThreads(shares, std::cref(work));
}

}  // namespace superray
