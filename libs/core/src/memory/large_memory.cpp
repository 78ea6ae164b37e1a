// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/large_memory.h>

#include "memory/huge_page_supply.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace superray {

#ifdef __linux__
namespace {

/// One for all areas: they share what the system has.
HugePageSupply hugePageSupply;

std::uintptr_t toHugePages(std::uintptr_t bytes) {
    return (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

/// Beginning with a huge page. \pre bytes is a multiple of kHugePage
std::byte* mapArea(std::size_t bytes) {
    void* const area = mmap(nullptr, bytes + kHugePage, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (area == MAP_FAILED) throw std::bad_alloc();
    auto* const begin = static_cast<std::byte*>(area);
    const auto address = reinterpret_cast<std::uintptr_t>(area);
    const std::size_t before = toHugePages(address) - address;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, kHugePage - before);
    return begin + before;
}

}  // namespace

LargeMemory::LargeMemory(std::size_t bytes) : mapped_(bytes >= kHugePage) {
    size_ = mapped_ ? toHugePages(bytes) : bytes;
    data_ = mapped_ ? mapArea(size_) : new std::byte[size_];
}

LargeMemory::~LargeMemory() {
    if (mapped_)
        munmap(data_, size_);
    else
        delete[] data_;
}

void LargeMemory::choosePages(std::size_t bytes) {
    for (; chosen_ < bytes; chosen_ += kHugePage) {
        const auto begin = HugePageSupply::Clock::now();
        const bool huge = hugePageSupply.hasPage(begin);
        // For all of the area, as pieces that differ could not be moved as one. What
        // has been touched stays as it is. If it fails, pages are small.
        if (huge != huge_) madvise(data_, size_, huge ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
        huge_ = huge;
        if (!huge) continue;
        *static_cast<volatile std::byte*>(data_ + chosen_) = std::byte{0};
        hugePageSupply.noteTouch(begin, HugePageSupply::Clock::now());
    }
}
#else
LargeMemory::LargeMemory(std::size_t bytes) : data_(new std::byte[bytes]), size_(bytes) {}
LargeMemory::~LargeMemory() {
    delete[] data_;
}
void LargeMemory::choosePages(std::size_t) {}
#endif

void LargeMemory::grow(std::size_t bytes) {
    if (bytes <= size_) return;
    LargeMemory larger(bytes);
#ifdef __linux__
    if (mapped_) {
        // The pages move, not what is in them.
        if (mremap(data_, size_, larger.size_, MREMAP_MAYMOVE | MREMAP_FIXED, larger.data_) ==
            MAP_FAILED)
            throw std::bad_alloc();
        data_ = std::exchange(larger.data_, nullptr);
        size_ = std::exchange(larger.size_, 0);
        larger.mapped_ = false;
        return;
    }
#endif
    larger.expectWrites(size_);
    if (size_ > 0) std::memcpy(larger.data_, data_, size_);
    swap(larger);
}

void LargeMemory::swap(LargeMemory& o) noexcept {
    std::swap(data_, o.data_);
    std::swap(size_, o.size_);
    std::swap(chosen_, o.chosen_);
    std::swap(mapped_, o.mapped_);
    std::swap(huge_, o.huge_);
}

ZeroedBytes::ZeroedBytes(const ZeroedBytes& o) {
    append(o.size_);
    if (o.size_ > 0) std::memcpy(data(), o.data(), o.size_);
}

void ZeroedBytes::swap(ZeroedBytes& o) noexcept {
    memory_.swap(o.memory_);
    std::swap(size_, o.size_);
}

void ZeroedBytes::append(std::size_t n) {
    const std::size_t end = size_ + n;
    if (end + kSlack > memory_.size()) memory_.grow(std::max(end + kSlack, 2 * memory_.size()));
    memory_.expectWrites(end);
    // Also what the system gives, which is zero as it is: reading it before it is
    // written would take two page faults instead of one.
    std::memset(data() + size_, 0, n);
    size_ = end;
}

}  // namespace superray
