#include "distance_field.h"

#include <algorithm>
#include <cmath>

namespace superray {
namespace {

constexpr int kEdge = kBlockEdge;

/// Occupied cells of one row along x; bit 0 is the first cell of the window.
__extension__ using RowBits = unsigned __int128;

int lowestBit(RowBits v) {
    const auto low = static_cast<std::uint64_t>(v);
    return low ? __builtin_ctzll(low)
               : 64 + __builtin_ctzll(static_cast<std::uint64_t>(v >> 64));
}
int highestBit(RowBits v) {
    const auto high = static_cast<std::uint64_t>(v >> 64);
    return high ? 127 - __builtin_clzll(high)
                : 63 - __builtin_clzll(static_cast<std::uint64_t>(v));
}

/// to = min(to, from + step) for n codes.
void takeNearer(const std::int32_t* from, std::int32_t step, std::int32_t* to, int n) {
    for (int i = 0; i < n; ++i) {
        const std::int32_t v = from[i] + step;
        to[i] = v < to[i] ? v : to[i];
    }
}

}  // namespace

/// The exact squared distance is separable: nearest along x in each row, the
/// best of these along y, the best of those along z.
template <int Dim>
struct DistanceField<Dim>::Window {
    int reach, span;            ///< span: cells per axis that matter
    std::vector<RowBits> rows;  ///< [z][y], from -reach on
    bool any = false;

    explicit Window(double farthest)
        : reach(static_cast<int>(farthest)),
          span(kEdge + 2 * reach),
          rows(static_cast<std::size_t>(Dim == 3 ? span * span : span)) {}

    RowBits& row(int z, int y) { return rows[static_cast<std::size_t>(z * span + y)]; }
    const RowBits& row(int z, int y) const {
        return rows[static_cast<std::size_t>(z * span + y)];
    }

    /// Index of the window's first block relative to the asking one.
    int blocksAround() const { return (reach + kEdge - 1) / kEdge; }

    /// \param d position of the block relative to the asking one
    void add(const Cell<Dim>& d, const BlockMask<Dim>& mask) {
        any = true;
        const int shift = (d[0] + blocksAround()) * kEdge;
        for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
            const int z = Dim == 3 ? d[Dim - 1] * kEdge + w + reach : 0;
            if (z < 0 || z >= (Dim == 3 ? span : 1)) continue;
            for (int r = 0; r < kEdge; ++r) {
                const int y = d[1] * kEdge + r + reach;
                if (y < 0 || y >= span) continue;
                const auto byte = static_cast<std::uint8_t>(
                    mask.words[static_cast<std::size_t>(w)] >> (kEdge * r));
                row(z, y) |= RowBits{byte} << shift;
            }
        }
    }

    static std::int32_t stepCode(int axis, int distance) {
        return (distance * distance << kSquareShift) | (distance + kMaxReach)
                                                           << (kAxisBits * axis);
    }

    /// Nearest cell in the row for the block's 8 columns. \pre bits != 0
    void alongX(RowBits bits, std::int32_t* codes) const {
        const int first = blocksAround() * kEdge;
        for (int x = 0; x < kEdge; ++x) {
            const RowBits right = bits >> (first + x);
            const RowBits left = bits << (127 - first - x);  // this column becomes bit 127
            int best = kMaxReach + 1;
            if (right) best = lowestBit(right);
            if (left && 127 - highestBit(left) <= std::abs(best)) best = highestBit(left) - 127;
            codes[x] = std::abs(best) <= reach ? stepCode(0, best) : kNothing;
        }
    }

    /// \return false if no row of the plane has an occupied cell
    bool alongXY(int z, std::int32_t* plane) const {
        bool found = false;
        std::fill_n(plane, kEdge * kEdge, kNothing);
        for (int y = 0; y < span; ++y) {
            if (!row(z, y)) continue;
            found = true;
            std::array<std::int32_t, kEdge> nearest;
            alongX(row(z, y), nearest.data());
            for (int to = std::max(0, y - 2 * reach); to <= std::min(kEdge - 1, y); ++to)
                takeNearer(nearest.data(), stepCode(1, y - reach - to), plane + kEdge * to,
                           kEdge);
        }
        return found;
    }

    void compute(std::int32_t* codes) const {
        if constexpr (Dim == 2) {
            alongXY(0, codes);
        } else {
            std::fill_n(codes, kBlockCells<Dim>, kNothing);
            std::array<std::int32_t, kEdge * kEdge> plane;
            for (int z = 0; z < span; ++z) {
                if (!alongXY(z, plane.data())) continue;
                for (int to = std::max(0, z - 2 * reach); to <= std::min(kEdge - 1, z); ++to)
                    takeNearer(plane.data(), stepCode(2, z - reach - to),
                               codes + kEdge * kEdge * to, kEdge * kEdge);
            }
        }
    }
};

template <int Dim>
double DistanceField<Dim>::reachFor(double metres, double resolution) {
    // Between the centres lies at most the gap and half a diagonal at each end.
    return std::min<double>(kMaxReach, metres / resolution + std::sqrt(double{Dim}));
}

template <int Dim>
bool DistanceField<Dim>::isCurrent(const Source& source, double reach) const {
    return everRead_ && stamp_ == source.changes.stamp() && occupiedFrom_ == source.occupied &&
           reach_ >= reach;
}

template <int Dim>
void DistanceField<Dim>::readAll(const Source& source) {
    occupied_.clear();
    blocks_.clear();
    source.map.forEachBlock([&](const BlockView<Dim>& block) {
        BlockMask<Dim> mask;
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i) && block.values[i] >= source.occupied) mask.set(i);
        if (mask.any()) occupied_.emplace(block.key, mask);
    });
}

template <int Dim>
void DistanceField<Dim>::readBlock(const Source& source, const BlockKey<Dim>& key) {
    BlockMask<Dim> now;
    source.map.visitBlock(key, [&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i) && block.values[i] >= source.occupied) now.set(i);
    });
    const auto known = occupied_.find(key);
    BlockMask<Dim> changed = known == occupied_.end() ? BlockMask<Dim>{} : known->second;
    for (std::size_t w = 0; w < changed.words.size(); ++w) changed.words[w] ^= now.words[w];
    if (!changed.any()) return;
    if (!now.any())
        occupied_.erase(known);
    else
        occupied_[key] = now;
    dropAround(key, changed);
}

template <int Dim>
void DistanceField<Dim>::dropAround(const BlockKey<Dim>& key, const BlockMask<Dim>& changed) {
    if (blocks_.empty()) return;
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
    const int reach = static_cast<int>(reach_);
    BlockKey<Dim> from, to;
    for (std::size_t a = 0; a < Dim; ++a) {
        from[a] = key[a] + ((lowest[a] - reach) >> kBlockBits);
        to[a] = key[a] + ((highest[a] + reach) >> kBlockBits);
    }
    for (BlockKey<Dim> k = from;;) {
        if (const auto block = blocks_.find(k); block != blocks_.end())
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
    if (reach > reach_) {
        reach_ = reach;
        blocks_.clear();
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
void DistanceField<Dim>::compute(const BlockKey<Dim>& key, FieldBlock& block) const {
    Window window(reach_);
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
    const auto farthest = static_cast<std::int32_t>(reach_ * reach_);
    for (std::int32_t& code : *block.codes)
        if (code >> kSquareShift > farthest) code = kNothing;
}

template <int Dim>
template <class OnMissing>
bool DistanceField<Dim>::lookUp(const Cell<Dim>* cells, std::size_t count, Code* codes,
                                OnMissing onMissing) {
    BlockKey<Dim> lastKey{};
    const FieldBlock* last = nullptr;
    for (std::size_t i = 0; i < count; ++i) {
        const BlockKey<Dim> key = blockOf<Dim>(cells[i]);
        if (!last || key != lastKey) {
            const auto it = blocks_.find(key);
            last = it != blocks_.end() && it->second.valid ? &it->second : onMissing(key);
            if (!last) return false;
            lastKey = key;
        }
        const auto index = static_cast<std::size_t>(indexInBlock<Dim>(cells[i]));
        codes[i] = last->codes ? Code{(*last->codes)[index]} : Code{};
    }
    return true;
}

template <int Dim>
void DistanceField<Dim>::nearest(const Source& source, double reach, const Cell<Dim>* cells,
                                 std::size_t count, Code* codes) {
    {
        const std::shared_lock<std::shared_mutex> lock(mutex_);
        if (isCurrent(source, reach) && lookUp(cells, count, codes, [](const BlockKey<Dim>&) {
                return static_cast<FieldBlock*>(nullptr);
            }))
            return;
    }
    const std::unique_lock<std::shared_mutex> lock(mutex_);
    update(source, reach);
    lookUp(cells, count, codes, [&](const BlockKey<Dim>& key) {
        FieldBlock& block = blocks_[key];
        compute(key, block);
        return &block;
    });
}

template <int Dim>
std::size_t DistanceField<Dim>::validBlocks() const {
    const std::shared_lock<std::shared_mutex> lock(mutex_);
    return static_cast<std::size_t>(std::count_if(
        blocks_.begin(), blocks_.end(), [](const auto& b) { return b.second.valid; }));
}

template class DistanceField<2>;
template class DistanceField<3>;

}  // namespace superray
