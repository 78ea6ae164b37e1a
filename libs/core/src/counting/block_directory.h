// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Block index -> id, for the blocks of one scan.

#include <superray/core/block.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <new>
#include <unordered_map>
#include <vector>

namespace superray {

/// Inclusive bounds of blocks.
template <int Dim>
struct BlockBox {
    BlockKey<Dim> lo{}, hi{};
    bool contains(const BlockKey<Dim>& k) const {
        for (int a = 0; a < Dim; ++a)
            if (k[a] < lo[a] || k[a] > hi[a]) return false;
        return true;
    }
};

/// Ids of blocks, 0 for those that have none. Dense over the bounds of the scan, so a look-up
/// is a multiplication per axis and a load; a hash map serves bounds too large for that.
template <int Dim>
class BlockDirectory {
 public:
    /// Beyond this volume (2 GiB of address space) a hash map serves instead.
    static constexpr std::uint64_t kDenseLimit = std::uint64_t{1} << 29;
    /// Memory kept from scan to scan: up to this volume (64 MiB).
    static constexpr std::uint64_t kKeptVolume = std::uint64_t{1} << 24;

    /// Empties the directory and makes it cover `box`.
    void reset(const BlockBox<Dim>& box) {
        clear();
        box_ = box;
        std::uint64_t volume = 1;
        dense_ = true;
        for (int a = 0; a < Dim; ++a) {
            stride_[a] = static_cast<std::int64_t>(volume);
            volume *= static_cast<std::uint64_t>(box.hi[a] - box.lo[a] + 1);
            if (volume > kDenseLimit) dense_ = false;
        }
        if (!dense_ || volume <= capacity_) return;
        // Headroom, so that a growing extent does not allocate at every scan.
        capacity_ = volume < kKeptVolume ? 2 * volume : volume;
        // calloc: large areas come as untouched zero pages from the system.
        ids_.reset(static_cast<std::uint32_t*>(std::calloc(capacity_, sizeof(std::uint32_t))));
        if (!ids_) {
            capacity_ = 0;
            throw std::bad_alloc();
        }
    }

    bool dense() const { return dense_; }
    const BlockBox<Dim>& box() const { return box_; }
    /// Dense part: id(key) = data()[indexOf(key)].
    const std::uint32_t* data() const { return ids_.get(); }
    std::int64_t stride(int axis) const { return stride_[axis]; }
    std::int64_t indexOf(const BlockKey<Dim>& k) const {
        std::int64_t i = 0;
        for (int a = 0; a < Dim; ++a) i += (k[a] - box_.lo[a]) * stride_[a];
        return i;
    }

    /// Id of a block in the box; 0 if it has none.
    std::uint32_t id(const BlockKey<Dim>& k) const {
        if (dense_) return ids_[indexOf(k)];
        const auto it = sparse_.find(k);
        return it == sparse_.end() ? 0 : it->second;
    }
    void setId(const BlockKey<Dim>& k, std::uint32_t n) {
        if (dense_) {
            const std::int64_t i = indexOf(k);
            used_.push_back(i);  // first, as it may throw: clear() must find every id
            ids_[i] = n;
        } else {
            sparse_[k] = n;
        }
    }

 private:
    struct Free {
        void operator()(std::uint32_t* p) const { std::free(p); }
    };

    void clear() {
        if (capacity_ > kKeptVolume) {
            ids_.reset();
            capacity_ = 0;
        } else {
            for (std::int64_t i : used_) ids_[i] = 0;
        }
        used_.clear();
        sparse_.clear();
    }

    BlockBox<Dim> box_;
    std::array<std::int64_t, 3> stride_{};
    std::uint64_t capacity_ = 0;
    std::unique_ptr<std::uint32_t[], Free> ids_;
    std::vector<std::int64_t> used_;
    std::unordered_map<BlockKey<Dim>, std::uint32_t, IndexHash> sparse_;
    bool dense_ = true;
};

}  // namespace superray
