// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Memory for values that are written before they are read.

#include <cstddef>
#include <memory>
#include <type_traits>

namespace superray {

/// What to allocate for the n values of one scan, so that the next ones, which may be
/// somewhat larger, need no fresh memory, whose first touch takes longer than many a scan.
constexpr std::size_t withRoomForMore(std::size_t n) {
    return n + n / 4;
}

/// An array that is not initialised and does not keep its contents when it grows: what
/// is never written takes no memory.
template <typename T>
class ScratchArray {
    static_assert(std::is_trivially_default_constructible_v<T>);

 public:
    /// Room for at least `n`; what was there is lost.
    void reserve(std::size_t n) {
        if (n <= capacity_) return;
        values_.reset();
        capacity_ = 0;
        values_.reset(new T[withRoomForMore(n)]);
        capacity_ = withRoomForMore(n);
    }
    T* data() { return values_.get(); }
    const T* data() const { return values_.get(); }
    T& operator[](std::size_t i) { return values_[i]; }
    const T& operator[](std::size_t i) const { return values_[i]; }

 private:
    std::unique_ptr<T[]> values_;
    std::size_t capacity_ = 0;
};

}  // namespace superray
