// SPDX-License-Identifier: BSD-3-Clause
// encodeCells() and decodeCells(): see doc/file_format.md, "Cells".

#include <superray/storage/map_file.h>

#include "file/byte_io.h"
#include "file/deflate_stream.h"
#include "values/value_rules.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace superray {
namespace {

constexpr std::uint32_t kCellsVersion = 1;
constexpr std::size_t kCheckedHeader = 48;  // bytes before the checksum
constexpr std::size_t kHeader = kCheckedHeader + 4;
enum BlockKind : std::uint8_t { mixedBlock = 0, uniformBlock = 1 };

[[noreturn]] void fail(const std::string& what) {
    throw MapFileError("map cells: " + what);
}

struct CellsHeader {
    std::uint8_t dimension = 0;
    double resolution = 0;
    std::uint64_t blocks = 0, known = 0, rawSize = 0, deflatedSize = 0;
};

Bytes encodeHeader(const CellsHeader& h) {
    Bytes out;
    put(out, kCellsVersion);
    put(out, h.dimension);
    for (int i = 0; i < 3; ++i) put(out, std::uint8_t{0});
    put(out, h.resolution);
    put(out, h.blocks);
    put(out, h.known);
    put(out, h.rawSize);
    put(out, h.deflatedSize);
    return out;
}

/// Checks all that can be checked before a byte is inflated.
CellsHeader decodeHeader(const std::uint8_t* data, std::size_t size) {
    if (size < kHeader)
        fail(std::to_string(size) + " bytes are fewer than the header's " +
             std::to_string(kHeader));
    if (const auto version = get<std::uint32_t>(data); version != kCellsVersion)
        fail("version " + std::to_string(version) + " is not " + std::to_string(kCellsVersion));
    CellsHeader h;
    h.dimension = data[4];
    h.resolution = get<double>(data + 8);
    h.blocks = get<std::uint64_t>(data + 16);
    h.known = get<std::uint64_t>(data + 24);
    h.rawSize = get<std::uint64_t>(data + 32);
    h.deflatedSize = get<std::uint64_t>(data + 40);
    if (h.deflatedSize != size - kHeader)
        fail("deflated length " + std::to_string(h.deflatedSize) + " but " +
             std::to_string(size - kHeader) + " bytes are there");
    const std::uint32_t crc =
        crc32Of(data + kHeader, size - kHeader, crc32Of(data, kCheckedHeader));
    if (crc != get<std::uint32_t>(data + kCheckedHeader)) fail("checksum mismatch");
    if (data[5] || data[6] || data[7]) fail("reserved header bytes are not zero");
    if (h.rawSize / kMaxDeflateRatio > h.deflatedSize)
        fail("inflated length " + std::to_string(h.rawSize) + " is impossible for " +
             std::to_string(h.deflatedSize) + " deflated bytes");
    return h;
}

template <int Dim>
bool isUniform(const BlockView<Dim>& block) {
    return block.known.all() && std::all_of(block.values, block.values + kBlockCells<Dim>,
                                            [&](float v) { return v == block.values[0]; });
}

template <int Dim>
void encodeBlock(const BlockView<Dim>& block, Bytes& out) {
    for (const std::int32_t k : block.key) put(out, k);
    if (isUniform(block)) {
        put(out, std::uint8_t{uniformBlock});
        put(out, block.values[0]);
        return;
    }
    put(out, std::uint8_t{mixedBlock});
    for (const std::uint64_t word : block.known.words) put(out, word);
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (block.known.test(i)) put(out, block.values[i]);
}

/// Blocks one after the other from the deflated bytes, each validated.
template <int Dim>
class BlockReader {
 public:
    BlockReader(const std::uint8_t* deflated, std::size_t size) : stream_(deflated, size) {}

    /// \return the block; valid until the next call
    const BlockView<Dim>& next() {
        const BlockKey<Dim> previous = block_.key;
        for (auto& k : block_.key) k = number<std::int32_t>();
        if (!isAddressable(block_.key, kBlockLimit))
            fail("block outside the addressable range");
        if (!first_ && !(previous < block_.key)) fail("blocks are not in ascending order");
        first_ = false;
        block_.values = values_.data();
        switch (const auto kind = number<std::uint8_t>()) {
            case uniformBlock:
                block_.known.words.fill(~std::uint64_t{0});
                values_.fill(value());
                break;
            case mixedBlock:
                for (auto& word : block_.known.words) word = number<std::uint64_t>();
                if (!block_.known.any()) fail("block without known cells");
                for (int i = 0; i < kBlockCells<Dim>; ++i)
                    if (block_.known.test(i)) values_[static_cast<std::size_t>(i)] = value();
                break;
            default:
                fail("unknown block kind " + std::to_string(kind));
        }
        return block_;
    }

    /// \throws MapFileError unless exactly `rawSize` bytes were there
    void finish(std::uint64_t rawSize) {
        stream_.requireEnd();
        if (read_ != rawSize)
            fail("inflated length " + std::to_string(read_) + " is not the declared " +
                 std::to_string(rawSize));
    }

 private:
    template <typename T>
    T number() {
        std::uint8_t bytes[sizeof(T)];
        stream_.read(bytes, sizeof bytes);
        read_ += sizeof bytes;
        return get<T>(bytes);
    }
    float value() {
        const auto v = number<float>();
        if (!std::isfinite(v)) fail("log-odds that are not finite");
        return v;
    }

    InflateStream stream_;
    std::array<float, kBlockCells<Dim>> values_{};
    BlockView<Dim> block_{};
    bool first_ = true;
    std::uint64_t read_ = 0;
};

/// The memory that blocks take at most in a grid [bytes].
template <int Dim>
std::uint64_t memoryOf(const CellsHeader& h) {
    constexpr std::uint64_t kKeyAndKind = 4 * Dim + 1, kMask = kBlockCells<Dim> / 8;
    constexpr std::uint64_t kSmallestUniform = kKeyAndKind + sizeof(float);
    constexpr std::uint64_t kSmallestMixed = kKeyAndKind + kMask + sizeof(float);
    constexpr std::uint64_t kTableEntry = 64;
    constexpr std::uint64_t kMixed = kBlockCells<Dim> * sizeof(float) + 2 * kMask + 64;
    const std::uint64_t blocks = std::min(h.blocks, h.rawSize / kSmallestUniform);
    const std::uint64_t mixed = std::min(blocks, h.rawSize / kSmallestMixed);
    return blocks * kTableEntry + mixed * kMixed;
}

template <int Dim>
void requireBound(const OccupancyMap<Dim>& map, const MapFileLimits& limits, std::uint64_t read,
                  std::uint64_t blocks) {
    const std::size_t held = map.heldBytes();
    if (held <= limits.heldBytes) return;
    throw MemoryLimitError(limits.heldBytes, 0, held,
                           "cells not read: " + std::to_string(read) + " of " +
                               std::to_string(blocks) + " blocks take " + std::to_string(held) +
                               " bytes, the bound is " + std::to_string(limits.heldBytes) +
                               " bytes; raise max_memory_megabytes to keep such a map");
}

template <int Dim>
void decodeInto(const std::uint8_t* data, std::size_t size, OccupancyMap<Dim>& map,
                const MapFileLimits& limits) {
    const CellsHeader h = decodeHeader(data, size);
    if (h.dimension != Dim)
        fail("dimension " + std::to_string(h.dimension) + " for a map of dimension " +
             std::to_string(Dim));
    if (h.resolution != map.geometry().resolution())
        fail("resolution " + metresText(h.resolution) + " for a map of resolution " +
             metresText(map.geometry().resolution()));
    if (const auto bytes = memoryOf<Dim>(h); bytes > limits.mapBytes)
        fail(std::to_string(h.blocks) + " blocks need up to " + std::to_string(bytes) +
             " bytes of memory, the limit is " + std::to_string(limits.mapBytes) +
             " (SUPERRAY_MAP_MEGABYTES)");
    BlockReader<Dim> reader(data + kHeader, size - kHeader);
    std::uint64_t known = 0;
    for (std::uint64_t b = 0; b < h.blocks; ++b) {
        const BlockView<Dim>& block = reader.next();
        known += static_cast<std::uint64_t>(block.known.count());
        map.setBlock(block);
        // A look takes little, but blocks may be tiny.
        if (b % 64 == 63 || b + 1 == h.blocks) requireBound(map, limits, b + 1, h.blocks);
    }
    reader.finish(h.rawSize);
    if (known != h.known)
        fail(std::to_string(known) + " known cells, " + std::to_string(h.known) + " declared");
}

}  // namespace

template <int Dim>
std::vector<std::uint8_t> encodeCells(const OccupancyMap<Dim>& map) {
    // Storages visit in an order of their own; files have one order.
    Bytes raw;
    std::vector<std::pair<BlockKey<Dim>, std::size_t>> blocks;  // and offset in raw
    CellsHeader header;
    map.forEachBlock([&](const BlockView<Dim>& block) {
        blocks.emplace_back(block.key, raw.size());
        encodeBlock(block, raw);
        header.known += static_cast<std::uint64_t>(block.known.count());
    });
    blocks.emplace_back(BlockKey<Dim>{}, raw.size());  // where the last one ends
    std::vector<std::size_t> order(blocks.size() - 1);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return blocks[a].first < blocks[b].first; });

    DeflateStream stream;
    for (const std::size_t i : order)
        stream.write(raw.data() + blocks[i].second, blocks[i + 1].second - blocks[i].second);
    const Bytes deflated = stream.finish();

    header.dimension = Dim;
    header.resolution = map.geometry().resolution();
    header.blocks = order.size();
    header.rawSize = raw.size();
    header.deflatedSize = deflated.size();
    Bytes out = encodeHeader(header);
    put(out, crc32Of(deflated.data(), deflated.size(), crc32Of(out.data(), out.size())));
    out.insert(out.end(), deflated.begin(), deflated.end());
    return out;
}

template <int Dim>
void decodeCells(const std::uint8_t* data, std::size_t size, OccupancyMap<Dim>& map,
                 const MapFileLimits& limits) {
    try {
        const std::unique_ptr<OccupancyMap<Dim>> fresh = map.emptyLike(map.geometry());
        decodeInto(data, size, *fresh, limits);
        map.swapContents(*fresh);
    } catch (const std::bad_alloc&) {
        fail("not enough memory");
    } catch (const std::length_error& e) {
        fail(e.what());
    }
}

template std::vector<std::uint8_t> encodeCells<2>(const OccupancyMap<2>&);
template std::vector<std::uint8_t> encodeCells<3>(const OccupancyMap<3>&);
template void decodeCells<2>(const std::uint8_t*, std::size_t, OccupancyMap<2>&,
                             const MapFileLimits&);
template void decodeCells<3>(const std::uint8_t*, std::size_t, OccupancyMap<3>&,
                             const MapFileLimits&);

}  // namespace superray
