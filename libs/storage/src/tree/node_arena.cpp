// SPDX-License-Identifier: BSD-3-Clause
#include "tree/node_arena.h"

#include <superray/core/detail/grow.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace superray {

namespace {

/// What a share takes from the released nodes at once, at most.
constexpr std::size_t kMostFreeAtOnce = 1024;

}  // namespace

void NodeArena::FreeList::append(FreeList& o) {
    if (o.first == nullptr) return;
    if (first == nullptr)
        last = o.last;
    else
        o.last->next = first;
    first = std::exchange(o.first, nullptr);
    count += std::exchange(o.count, 0);
}

NodeArena::FreeList NodeArena::FreeList::takeSome(std::size_t n) {
    if (first == nullptr || n == 0) return {};
    FreeList taken{first, first, 1};
    for (; taken.count < n && taken.last->next != nullptr; ++taken.count)
        taken.last = taken.last->next;
    first = std::exchange(taken.last->next, nullptr);
    count -= taken.count;
    return taken;
}

std::size_t NodeArena::chunkSize(std::size_t arenaBytes, std::size_t least) {
    std::size_t bytes = kFirstChunk;
    while (bytes < kLastChunk && bytes < arenaBytes) bytes *= 2;
    while (bytes < least) bytes *= 2;
    return bytes;
}

std::size_t NodeArena::chunkBytesAtMost(const Demand& demand) const {
    const auto beyond = [](std::size_t wanted, std::size_t free) {
        return wanted - std::min(wanted, free);
    };
    // One of several shares may keep what was released from the others.
    const bool alone = demand.shares == 1;
    const std::size_t fresh =
        beyond(demand.nodes, alone ? nodes_.count : 0) * kNodeBytes +
        beyond(demand.families, alone ? families_.count : 0) * kFamilyBytes +
        // Each, and the one that makes the top, may leave a chunk in part.
        (alone ? 0 : (demand.shares + 1) * kLastChunk);
    // The last `step` bytes of each range may be left over, for they are too few.
    const auto usable = [&](std::size_t range) { return beyond(range, demand.step); };
    std::size_t room = 0, bytes = chunkBytes_;
    for (const Range& range : ranges_) room += usable(range.size());
    room += reserved_.size() * usable(kLastChunk);
    const bool hasRange = !reserved_.empty() ||
                          std::any_of(ranges_.begin(), ranges_.end(),
                                      [&](const Range& r) { return r.size() >= demand.step; });
    auto kept = room_.begin();
    for (bool enough = hasRange && room >= fresh; !enough; enough = room >= fresh) {
        const std::size_t chunk =
            kept != room_.end() ? (kept++)->bytes : chunkSize(bytes, demand.step);
        bytes += chunk;
        room += usable(chunk);
    }
    return bytes;
}

void NodeArena::keepRoom(const Demand& demand) {
    const std::size_t before = room_.size();
    try {
        std::size_t bytes = chunkBytes_;
        for (const Chunk& chunk : room_) bytes += chunk.bytes;
        for (const std::size_t needed = chunkBytesAtMost(demand); bytes < needed;) {
            room_.push_back(makeChunk(chunkSize(bytes, demand.step)));
            bytes += room_.back().bytes;
        }
        // For what the shares come to note.
        detail::growBy(chunks_, room_.size());
        detail::growBy(ranges_, room_.size() + reserved_.size() + 2 * demand.shares + 4);
    } catch (...) {
        room_.resize(before);  // others may need the memory
        throw;
    }
}

NodeArena::Range NodeArena::findChunk(std::size_t least) {
    if (!reserved_.empty() && least <= kLastChunk) {
        const Range chunk = reserved_.back();
        reserved_.pop_back();
        return chunk;
    }
    if (!room_.empty() && least <= room_.front().bytes) {
        const Range chunk = addChunk(std::move(room_.front()));
        room_.erase(room_.begin());
        return chunk;
    }
    return newChunk(least);
}

/// Its memory is not touched.
NodeArena::Chunk NodeArena::makeChunk(std::size_t bytes) {
    Chunk chunk;
    chunk.memory.reset(new std::byte[bytes]);
    chunk.bytes = bytes;
    return chunk;
}

NodeArena::Range NodeArena::newChunk(std::size_t least) {
    // Of small pages: huge ones save a fifth of an update where the system has them
    // at hand, but on virtual machines whose host must provide them first they take
    // six times as long as small ones, and a tree touches new ones at every scan.
    const std::size_t bytes = chunkSize(chunkBytes_, least);
    return addChunk(makeChunk(bytes));
}

NodeArena::Range NodeArena::addChunk(Chunk chunk) {
    std::byte* const begin = chunk.memory.get();
    chunks_.push_back(std::move(chunk.memory));
    chunkBytes_ += chunk.bytes;
    return {begin, begin + chunk.bytes};
}

void NodeArena::swap(NodeArena& o) noexcept {
    chunks_.swap(o.chunks_);
    ranges_.swap(o.ranges_);
    reserved_.swap(o.reserved_);
    room_.swap(o.room_);
    std::swap(nodes_, o.nodes_);
    std::swap(families_, o.families_);
    std::swap(chunkBytes_, o.chunkBytes_);
    noteFree();
    o.noteFree();
}

void NodeArena::clear() noexcept {
    chunks_.clear();
    ranges_.clear();
    reserved_.clear();
    room_.clear();
    nodes_ = families_ = {};
    chunkBytes_ = 0;
    noteFree();
}

void NodeArena::reserve(std::size_t bytes) {
    // In pieces, as several shares take them.
    reserved_.reserve(bytes / kLastChunk);
    while (reserved_.size() < bytes / kLastChunk) {
        const Range fresh = newChunk(kLastChunk);
        std::memset(fresh.begin, 0, fresh.size());
        reserved_.push_back(fresh);
    }
}

NodeArena::Share::Share(NodeArena& arena) : arena_(arena) {
    const std::lock_guard<std::mutex> lock(arena.mutex_);
    ++arena.shares_;
    try {
        arena.keepRoomForRanges();
    } catch (...) {
        --arena.shares_;
        throw;
    }
}

NodeArena::Share::~Share() {
    const std::lock_guard<std::mutex> lock(arena_.mutex_);
    --arena_.shares_;
    for (const Range& r : {spare_, current_})
        if (r.size() > 0) arena_.ranges_.push_back(r);
    arena_.nodes_.append(nodes_);
    arena_.families_.append(families_);
    arena_.noteFree();
}

void NodeArena::Share::useSpare() {
    // What is left is too small for a family, but not for nodes.
    for (; current_.size() >= kNodeBytes; current_.begin += kNodeBytes)
        nodes_.push(current_.begin);
    current_ = std::exchange(spare_, {});
}

void NodeArena::Share::findRoom(std::size_t bytes) {
    const std::lock_guard<std::mutex> lock(arena_.mutex_);
    auto& ranges = arena_.ranges_;
    arena_.keepRoomForRanges();
    // However small: it is used up before the spare one.
    if (current_.size() == 0 && !ranges.empty()) {
        current_ = ranges.back();
        ranges.pop_back();
        if (current_.size() >= bytes) return;
    }
    const auto enough = std::find_if(ranges.begin(), ranges.end(),
                                     [&](const Range& r) { return r.size() >= bytes; });
    if (enough != ranges.end()) {
        std::swap(spare_, *enough);
        if (enough->size() == 0) ranges.erase(enough);
        return;
    }
    const Range fresh = arena_.findChunk(bytes);
    if (spare_.size() > 0) ranges.push_back(spare_);
    spare_ = fresh;
}

void NodeArena::Share::findFree() {
    const std::lock_guard<std::mutex> lock(arena_.mutex_);
    if (nodes_.first == nullptr) nodes_ = arena_.nodes_.takeSome(freeAtOnce_);
    if (families_.first == nullptr) families_ = arena_.families_.takeSome(freeAtOnce_);
    // Counting them off takes its time: a share that writes one cell needs few.
    freeAtOnce_ = std::min(2 * freeAtOnce_, kMostFreeAtOnce);
    arena_.noteFree();
}

}  // namespace superray
