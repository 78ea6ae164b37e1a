// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Cells to count, gathered by the walks.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace superray {

/// Free cells that wait to be counted, as offsets into the miss counts of a batch.
class AddressBuffer {
 public:
    /// Room for `n` more, and for a vector register beyond.
    void reserveMore(std::size_t n) {
        if (size_ + n + kSlack > storage_.size()) storage_.resize(2 * (size_ + n + kSlack));
    }
    /// \pre reserved
    void push(std::uint32_t address) { storage_[size_++] = address; }
    std::uint32_t* end() { return storage_.data() + size_; }
    void setEnd(const std::uint32_t* end) {
        size_ = static_cast<std::size_t>(end - storage_.data());
    }
    const std::uint32_t* begin() const { return storage_.data(); }
    std::size_t size() const { return size_; }
    void clear() { size_ = 0; }

 private:
    static constexpr std::size_t kSlack = 16;
    std::vector<std::uint32_t> storage_;
    std::size_t size_ = 0;
};

}  // namespace superray
