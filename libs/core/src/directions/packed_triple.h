// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Three small numbers in one word.

#include <cstdint>

namespace superray {

/// Three numbers of 20 bits in one word. The bit above each of them stays clear, so that one
/// subtraction compares all three: a borrow shows there.
class PackedTriple {
 public:
    static constexpr int kBits = 21;

    PackedTriple() = default;  ///< not initialised, unlike PackedTriple{}
    explicit PackedTriple(std::uint64_t packed) : packed_(packed) {}
    /// \pre the number is 0 so far; 0 <= value < 2^20
    void set(int i, std::int32_t value) {
        packed_ |= std::uint64_t{static_cast<std::uint32_t>(value)} << (kBits * i);
    }
    std::int32_t operator[](std::uint32_t i) const {
        return static_cast<std::int32_t>(packed_ >> (kBits * i) & (kAbove - 1));
    }
    bool operator==(PackedTriple o) const { return packed_ == o.packed_; }
    bool operator!=(PackedTriple o) const { return packed_ != o.packed_; }
    /// Whether none of the numbers is greater than the other's.
    bool within(PackedTriple o) const {
        return (((o.packed_ | kAll) - packed_) & kAll) == kAll;
    }
    /// The greater ones.
    PackedTriple joined(PackedTriple o) const {
        const std::uint64_t others = ((o.packed_ | kAll) - packed_) & kAll;
        const std::uint64_t mask = others - (others >> (kBits - 1));  // whole fields
        return PackedTriple((o.packed_ & mask) | (packed_ & ~mask));
    }

    std::uint64_t packed() const { return packed_; }
    static constexpr std::uint64_t kAbove = std::uint64_t{1} << (kBits - 1);
    /// The bits above all numbers.
    static constexpr std::uint64_t kAll = kAbove | kAbove << kBits | kAbove << (2 * kBits);

 private:
    std::uint64_t packed_;
};

}  // namespace superray
