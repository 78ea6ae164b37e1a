// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/parallel.h>

#include <algorithm>
#include <exception>
#include <execution>
#include <numeric>
#include <thread>
#include <vector>

namespace superray {
namespace {

#ifdef __SANITIZE_THREAD__
/// ThreadSanitizer does not see what orders the threads of a pool that is not compiled for
/// it, and would find races everywhere.
template <typename Work>
void forEach(const std::vector<std::size_t>& chunks, const Work& work) {
    std::vector<std::thread> threads;
    for (const std::size_t chunk : chunks) threads.emplace_back(work, chunk);
    for (std::thread& t : threads) t.join();
}
#else
template <typename Work>
void forEach(const std::vector<std::size_t>& chunks, const Work& work) {
    std::for_each(std::execution::par, chunks.begin(), chunks.end(), work);
}
#endif

}  // namespace

void inThreads(std::size_t chunks, const std::function<void(std::size_t)>& work) {
    std::vector<std::size_t> numbers(chunks);
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    // An exception that leaves a parallel algorithm ends the program.
    std::vector<std::exception_ptr> failures(chunks);
    forEach(numbers, [&](std::size_t chunk) {
        try {
            work(chunk);
        } catch (...) {
            failures[chunk] = std::current_exception();
        }
    });
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace superray
