// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file change_log.h
/// Which blocks of a map have changed since when.

#include <superray/core/block.h>

#include <atomic>
#include <cstdint>
#include <unordered_set>
#include <vector>

namespace superray {

/// A counter that every change of a map advances, and the blocks that changed
/// with it. Blocks are recorded from the first stamp() on, so that maps whose
/// changes nobody follows pay nothing.
///
/// const members may be called concurrently; the others are for the writer.
template <int Dim>
class ChangeLog {
 public:
    using Stamp = std::uint64_t;

    ChangeLog() = default;
    ChangeLog(const ChangeLog&) = delete;
    ChangeLog& operator=(const ChangeLog&) = delete;

    /// The counter now: what changes later is "since" this stamp.
    Stamp stamp() const {
        Stamp nothingRecorded = kNever;
        completeSince_.compare_exchange_strong(nothingRecorded, now_);
        return now_;
    }

    /// Calls visit(key) once for each block that may have changed since a stamp;
    /// the work is proportional to their number.
    /// \return false, and nothing is visited, if the whole map may have changed
    template <class Visit>
    bool forEachSince(Stamp since, Visit&& visit) const {
        if (since < completeSince_) return false;
        std::unordered_set<BlockKey<Dim>, IndexHash> seen;
        for (auto e = entries_.rbegin(); e != entries_.rend() && e->stamp > since; ++e)
            if (seen.insert(e->key).second) visit(e->key);
        return true;
    }

    // --- writing --------------------------------------------------------------
    /// Begins a change; to be followed by add() for the blocks it touches.
    void begin() {
        ++now_;
        if (entries_.size() > limit_) dropOlderEntries();
    }
    bool recording() const { return completeSince_ != kNever; }
    void add(const BlockKey<Dim>& key) {
        if (recording()) entries_.push_back({now_, key});
    }
    /// The contents were replaced.
    void everything() {
        ++now_;
        if (recording()) completeSince_ = now_;
        entries_.clear();
    }

 private:
    struct Entry {
        Stamp stamp;
        BlockKey<Dim> key;
    };
    static constexpr Stamp kNever = ~Stamp{0};
    static constexpr std::size_t kSmall = 4096;
    /// Blocks to keep in mind. A map that slides along meets new ones for ever, and to
    /// read so many takes as long as to read a map.
    static constexpr std::size_t kMostBlocks = std::size_t{1} << 18;

    /// Keeps the last entry of each block; of very many blocks, the later half.
    void dropOlderEntries() {
        std::unordered_set<BlockKey<Dim>, IndexHash> seen;
        std::vector<Entry> kept;
        for (auto e = entries_.rbegin(); e != entries_.rend(); ++e)
            if (seen.insert(e->key).second) kept.push_back(*e);
        if (kept.size() > kMostBlocks) {
            completeSince_ = kept[kMostBlocks / 2].stamp;
            kept.resize(kMostBlocks / 2);
        }
        entries_.assign(kept.rbegin(), kept.rend());
        limit_ = kSmall + 4 * entries_.size();
    }

    Stamp now_ = 0;
    mutable std::atomic<Stamp> completeSince_{kNever};
    std::vector<Entry> entries_;  // by stamp
    std::size_t limit_ = kSmall;
};

}  // namespace superray
