// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How much of an area the system has given memory to.

#ifdef __linux__
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace superray::test {

/// Bytes of the pages that lie in the area as a whole.
struct PagesOf {
    std::size_t bytes, resident;
};
inline PagesOf pagesOf(const void* area, std::size_t bytes) {
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto address = reinterpret_cast<std::uintptr_t>(area);
    const std::uintptr_t begin = (address + page - 1) / page * page;
    std::vector<unsigned char> pages((address + bytes - begin) / page);
    // mincore() asks for a pointer to what may be changed, but changes nothing.
    EXPECT_EQ(mincore(reinterpret_cast<void*>(begin), pages.size() * page, pages.data()), 0);
    const auto resident =
        std::count_if(pages.begin(), pages.end(), [](auto p) { return p & 1; });
    return {pages.size() * page, static_cast<std::size_t>(resident) * page};
}

}  // namespace superray::test
#endif
