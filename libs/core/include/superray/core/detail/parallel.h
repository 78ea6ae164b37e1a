// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file parallel.h
/// Loops in several threads, for the libraries of this project; no public interface.

#include <algorithm>
#include <cstddef>
#include <functional>

namespace superray {

/// First of `n` elements that belong to a chunk, of `chunks` about equal ones.
inline std::size_t chunkBegin(std::size_t n, std::size_t chunk, std::size_t chunks) {
    return n * chunk / chunks;
}

/// Number of chunks for `n` elements, with at least `perChunk` in each: 1 .. `threads`.
/// \pre threads > 0
inline std::size_t chunkCountFor(std::size_t n, std::size_t perChunk, std::size_t threads) {
    return std::max<std::size_t>(1, std::min(threads, n / perChunk));
}

/// As inParallel(), for two chunks or more.
void inThreads(std::size_t chunks, const std::function<void(std::size_t)>& work);

/// Runs work(chunk) for the chunks 0 .. chunks-1, in this thread and in others that the
/// process keeps for that: as many at once as the machine has processors, so a chunk must
/// not wait for one that has not begun. A single chunk is like a call of work(0).
/// \throws the exception of the first chunk that failed, when all have ended
template <typename Work>
void inParallel(std::size_t chunks, const Work& work) {
    if (chunks == 1) return work(std::size_t{0});
    inThreads(chunks, std::cref(work));
}

}  // namespace superray
