#include <superray/core/parallel.h>

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
void forEach(const std::vector<std::size_t>& shares, const Work& work) {
    std::vector<std::thread> threads;
    for (const std::size_t share : shares) threads.emplace_back(work, share);
    for (std::thread& t : threads) t.join();
}
#else
template <typename Work>
void forEach(const std::vector<std::size_t>& shares, const Work& work) {
    std::for_each(std::execution::par, shares.begin(), shares.end(), work);
}
#endif

}  // namespace

void inThreads(std::size_t shares, const std::function<void(std::size_t)>& work) {
    std::vector<std::size_t> numbers(shares);
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    // An exception that leaves a parallel algorithm ends the program.
    std::vector<std::exception_ptr> failures(shares);
    forEach(numbers, [&](std::size_t share) {
        try {
            work(share);
        } catch (...) {
            failures[share] = std::current_exception();
        }
    });
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace superray
