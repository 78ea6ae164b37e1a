// SPDX-License-Identifier: BSD-3-Clause
#include "queries/distance_field.h"

#include <algorithm>
#include <cmath>

#include "queries/distance_window.h"

namespace superray {
namespace {

constexpr int kEdge = kBlockEdge;

template <int Dim>
BlockMask<Dim> occupiedCells(const BlockView<Dim>& block, float occupied) {
    BlockMask<Dim> mask;
    const float* values = block.values;
    for (std::size_t w = 0; w < mask.words.size(); ++w, values += 64) {
        const std::uint64_t known = block.known.words[w];
        if (~known == 0) {  // without branches: a scan changes many such blocks
            for (int i = 0; i < 64; ++i)
                mask.words[w] |= std::uint64_t{values[i] >= occupied} << i;
        } else {
            for (std::uint64_t bits = known; bits; bits &= bits - 1) {
                const int i = __builtin_ctzll(bits);
                mask.words[w] |= std::uint64_t{values[i] >= occupied} << i;
            }
        }
    }
    return mask;
}

}  // namespace

template <int Dim>
double DistanceField<Dim>::reachFor(double metres, double resolution) {
    // Between the centres lies at most the gap and half a diagonal at each end.
    return std::min<double>(kMaxReach, metres / resolution + std::sqrt(double{Dim}));
}

template <int Dim>
bool DistanceField<Dim>::isCurrent(const Source& source, double reach) const {
    return everRead_ && stamp_ == source.changes.stamp() && occupiedFrom_ == source.occupied &&
           far_.reach >= reach;
}

template <int Dim>
void DistanceField<Dim>::readAll(const Source& source) {
    occupied_.clear();
    near_.blocks.clear();
    far_.blocks.clear();
    source.map.forEachBlock([&](const BlockView<Dim>& block) {
        const BlockMask<Dim> mask = occupiedCells<Dim>(block, source.occupied);
        if (mask.any()) occupied_.emplace(block.key, mask);
    });
}

template <int Dim>
void DistanceField<Dim>::readBlock(const Source& source, const BlockKey<Dim>& key) {
    BlockMask<Dim> now;
    const bool known = source.map.visitBlock(key, [&](const BlockView<Dim>& block) {
        now = occupiedCells<Dim>(block, source.occupied);
    });
    // Forgotten: nobody is likely to ask there again, and a sliding window leaves many.
    if (!known)
        for (Layer* layer : {&near_, &far_}) layer->blocks.erase(key);
    const auto before = occupied_.find(key);
    BlockMask<Dim> changed = before == occupied_.end() ? BlockMask<Dim>{} : before->second;
    for (std::size_t w = 0; w < changed.words.size(); ++w) changed.words[w] ^= now.words[w];
    if (!changed.any()) return;
    if (!now.any())
        occupied_.erase(before);
    else
        occupied_[key] = now;
    for (Layer* layer : {&near_, &far_}) dropAround(*layer, key, changed);
}

template <int Dim>
void DistanceField<Dim>::dropAround(Layer& layer, const BlockKey<Dim>& key,
                                    const BlockMask<Dim>& changed) {
    if (layer.blocks.empty()) return;
    Cell<Dim> lowest, highest;
    lowest.fill(kEdge);
    highest.fill(-1);
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        if (!changed.test(i)) continue;
        const Cell<Dim> c = cellInBlock<Dim>({}, i);
        for (std::size_t a = 0; a < Dim; ++a) {
            lowest[a] = std::min(lowest[a], c[a]);
            highest[a] = std::max(highest[a], c[a]);
        }
    }
    const int reach = static_cast<int>(layer.reach);
    BlockKey<Dim> from, to;
    for (std::size_t a = 0; a < Dim; ++a) {
        from[a] = key[a] + ((lowest[a] - reach) >> kBlockBits);
        to[a] = key[a] + ((highest[a] + reach) >> kBlockBits);
    }
    std::size_t around = 1;
    for (std::size_t a = 0; a < Dim; ++a)
        around *= static_cast<std::size_t>(to[a] - from[a] + 1);
    if (around > layer.blocks.size()) {
        for (auto& [k, block] : layer.blocks) {
            bool inside = true;
            for (std::size_t a = 0; a < Dim; ++a)
                inside = inside && k[a] >= from[a] && k[a] <= to[a];
            if (inside) block.valid = false;
        }
        return;
    }
    for (BlockKey<Dim> k = from;;) {
        if (const auto block = layer.blocks.find(k); block != layer.blocks.end())
            block->second.valid = false;
        std::size_t a = 0;
        while (a < Dim && k[a] == to[a]) {
            k[a] = from[a];
            ++a;
        }
        if (a == Dim) break;
        ++k[a];
    }
}

template <int Dim>
void DistanceField<Dim>::update(const Source& source, double reach) {
    if (isCurrent(source, reach)) return;
    if (reach > far_.reach) {
        far_.reach = reach;
        far_.blocks.clear();
        if (near_.reach < kNearReach) near_.blocks.clear();
        near_.reach = std::min(reach, kNearReach);
    }
    const auto now = source.changes.stamp();
    const bool sameRule = everRead_ && occupiedFrom_ == source.occupied;
    if (!sameRule || !source.changes.forEachSince(
                         stamp_, [&](const BlockKey<Dim>& key) { readBlock(source, key); }))
        readAll(source);
    everRead_ = true;
    occupiedFrom_ = source.occupied;
    stamp_ = now;
}

template <int Dim>
void DistanceField<Dim>::compute(const BlockKey<Dim>& key, double reach,
                                 FieldBlock& block) const {
    Window window(reach);
    const int around = window.blocksAround();
    Cell<Dim> d;
    d.fill(-around);
    for (;;) {
        BlockKey<Dim> k;
        for (std::size_t a = 0; a < Dim; ++a) k[a] = key[a] + d[a];
        if (const auto it = occupied_.find(k); it != occupied_.end()) window.add(d, it->second);
        std::size_t a = 0;
        while (a < Dim && d[a] == around) d[a++] = -around;
        if (a == Dim) break;
        ++d[a];
    }
    block.valid = true;
    if (!window.any) {
        block.codes.reset();
        return;
    }
    if (!block.codes) block.codes = std::make_unique<Codes>();
    window.compute(block.codes->data());
    const auto farthest = static_cast<std::int32_t>(reach * reach);
    for (std::int32_t& code : *block.codes)
        if (code >> kSquareShift > farthest) code = kNothing;
}

template <int Dim>
template <class OnMissing>
bool DistanceField<Dim>::lookUp(const Cell<Dim>* cells, std::size_t count, Code* codes,
                                OnMissing onMissing) {
    struct Last {
        Layer& layer;
        BlockKey<Dim> key{};
        const FieldBlock* block = nullptr;
    };
    Last lastNear{near_}, lastFar{far_};
    /// False: given up.
    const auto read = [&](Last& last, const Cell<Dim>& cell, Code& code) {
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!last.block || key != last.key) {
            const auto it = last.layer.blocks.find(key);
            last.block = it != last.layer.blocks.end() && it->second.valid
                             ? &it->second
                             : onMissing(last.layer, key);
            if (!last.block) return false;
            last.key = key;
        }
        const auto index = static_cast<std::size_t>(indexInBlock<Dim>(cell));
        code = last.block->codes ? Code{(*last.block->codes)[index]} : Code{};
        return true;
    };
    const bool twoLayers = far_.reach > near_.reach;
    for (std::size_t i = 0; i < count; ++i) {
        if (!read(lastNear, cells[i], codes[i])) return false;
        if (twoLayers && !codes[i].found() && !read(lastFar, cells[i], codes[i])) return false;
    }
    return true;
}

template <int Dim>
void DistanceField<Dim>::nearest(const Source& source, double reach, const Cell<Dim>* cells,
                                 std::size_t count, Code* codes) {
    {
        const std::shared_lock<std::shared_mutex> lock(mutex_);
        if (isCurrent(source, reach) &&
            lookUp(cells, count, codes, [](Layer&, const BlockKey<Dim>&) {
                return static_cast<const FieldBlock*>(nullptr);
            }))
            return;
    }
    const std::unique_lock<std::shared_mutex> lock(mutex_);
    update(source, reach);
    lookUp(cells, count, codes, [&](Layer& layer, const BlockKey<Dim>& key) {
        FieldBlock& block = layer.blocks[key];
        compute(key, layer.reach, block);
        return static_cast<const FieldBlock*>(&block);
    });
}

template <int Dim>
std::size_t DistanceField<Dim>::validBlocks() const {
    const std::shared_lock<std::shared_mutex> lock(mutex_);
    std::size_t valid = 0;
    for (const Layer* layer : {&near_, &far_})
        for (const auto& entry : layer->blocks) valid += entry.second.valid ? 1 : 0;
    return valid;
}

template class DistanceField<2>;
template class DistanceField<3>;

}  // namespace superray
