#include <superray/core/parallel.h>

#include <algorithm>
#include <exception>
#include <execution>
#include <numeric>
#include <vector>

namespace superray {

void inParallel(std::size_t shares, const std::function<void(std::size_t)>& work) {
    if (shares == 1) return work(0);
    std::vector<std::size_t> numbers(shares);
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    // An exception that leaves a parallel algorithm ends the program.
    std::vector<std::exception_ptr> failures(shares);
    std::for_each(std::execution::par, numbers.begin(), numbers.end(),
                  [&](std::size_t share) {
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
