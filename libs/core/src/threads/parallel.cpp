// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/parallel.h>
#include <superray/core/detail/sanitizers.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <execution>
#include <limits>
#include <mutex>
#include <new>
#include <thread>
#include <utility>
#include <vector>

namespace superray {
namespace {

#if SUPERRAY_THREAD_SANITIZER
/// ThreadSanitizer does not see what orders the threads of a pool that is not compiled for
/// it, and would find races everywhere.
template <typename Work>
void callAtOnce(std::size_t times, const Work& work) {
    struct Threads : std::vector<std::thread> {
        ~Threads() {
            for (std::thread& t : *this) t.join();
        }
    } threads;
    threads.reserve(times);
    for (std::size_t i = 0; i < times; ++i) threads.emplace_back(work);
}
#else
template <typename Work>
void callAtOnce(std::size_t times, const Work& work) {
    const std::vector<char> calls(times);
    std::for_each(std::execution::par, calls.begin(), calls.end(), [&](char) { work(); });
}
#endif

/// The exception of the first chunk that failed.
class FirstFailure {
 public:
    void keep(std::size_t chunk, std::exception_ptr failure) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (chunk >= chunk_) return;
        chunk_ = chunk;
        failure_ = std::move(failure);
    }
    void rethrow() const {
        if (failure_) std::rethrow_exception(failure_);
    }

 private:
    std::mutex mutex_;
    std::size_t chunk_ = std::numeric_limits<std::size_t>::max();
    std::exception_ptr failure_;
};

}  // namespace

void inThreads(std::size_t chunks, const std::function<void(std::size_t)>& work) {
    FirstFailure failure;
    std::atomic<std::size_t> next{0};
    // An exception that leaves a parallel algorithm ends the program.
    const auto workOnNext = [&] {
        const std::size_t chunk = next++;
        try {
            work(chunk);
        } catch (...) {
            failure.keep(chunk, std::current_exception());
        }
    };
    try {
        callAtOnce(chunks, workOnNext);
    } catch (const std::bad_alloc&) {
        // There is no memory for more threads: this one does what they have not begun.
        while (next < chunks) workOnNext();
    }
    failure.rethrow();
}

}  // namespace superray
