// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/shared_storage.h>

#include <algorithm>
#include <mutex>
#include <typeinfo>
#include <unordered_map>

namespace superray {

/// The contents in memory whose bytes are known. A few words of the bytes (they
/// begin with counts and a checksum of the rest) find candidates; all bytes decide.
template <int Dim>
class SharedStorage<Dim>::Registry {
 public:
    // Never destroyed: maps may outlive every static object.
    static Registry& instance() {
        static auto* const registry = new Registry;
        return *registry;
    }

    std::mutex mutex;

    std::shared_ptr<Held> find(const std::type_info& type, const Bytes& bytes) {
        const auto range = known_.equal_range(keyOf(bytes));
        for (auto it = range.first; it != range.second; ++it) {
            auto held = it->second.lock();
            const OccupancyMap<Dim>* map = held ? held->map.get() : nullptr;
            if (map && typeid(*map) == type && *held->encoded == bytes) return held;
        }
        return nullptr;
    }

    void add(const std::shared_ptr<Held>& held) {
        dropDead();
        known_.emplace(keyOf(*held->encoded), held);
    }

    /// \pre held->encoded
    void remove(const std::shared_ptr<Held>& held) {
        const auto range = known_.equal_range(keyOf(*held->encoded));
        for (auto it = range.first; it != range.second; ++it)
            if (it->second.lock() == held) {
                known_.erase(it);
                return;
            }
    }

 private:
    static constexpr std::size_t kHeaderBytes = 64;

    static std::uint64_t keyOf(const Bytes& bytes) {
        std::uint64_t h = 0xCBF29CE484222325ull;
        const std::size_t n = std::min(bytes.size(), kHeaderBytes);
        for (std::size_t i = 0; i < n; ++i) h = (h ^ bytes[i]) * 0x100000001B3ull;
        return h;
    }

    void dropDead() {
        if (known_.size() < limit_) return;
        for (auto it = known_.begin(); it != known_.end();)
            it = it->second.expired() ? known_.erase(it) : std::next(it);
        limit_ = 64 + 2 * known_.size();
    }

    std::unordered_multimap<std::uint64_t, std::weak_ptr<Held>> known_;
    std::size_t limit_ = 64;
};

template <int Dim>
SharedStorage<Dim>::SharedStorage(std::unique_ptr<OccupancyMap<Dim>> map)
    : held_(std::make_shared<Held>(std::move(map))) {}

template <int Dim>
SharedStorage<Dim> SharedStorage<Dim>::decoded(StorageType type,
                                               const CellGeometry<Dim>& geometry,
                                               const Bytes& bytes,
                                               const MapFileLimits& limits) {
    SharedStorage fresh(makeStorage<Dim>(type, geometry));
    Registry& registry = Registry::instance();
    {
        const OccupancyMap<Dim>& map = *fresh;
        const std::lock_guard<std::mutex> lock(registry.mutex);
        // The same bytes have the same resolution.
        if (auto held = registry.find(typeid(map), bytes);
            held && held->map->geometry().resolution() == geometry.resolution()) {
            fresh.held_ = std::move(held);
            return fresh;
        }
    }
    decodeCells(bytes.data(), bytes.size(), *fresh.held_->map, limits);
    return fresh;
}

template <int Dim>
OccupancyMap<Dim>& SharedStorage<Dim>::writable() {
    Registry& registry = Registry::instance();
    // A count of 1 may grow only by way of the registry, that is under its lock.
    std::unique_lock<std::mutex> lock(registry.mutex);
    if (held_.use_count() > 1) {
        const std::shared_ptr<Held> shared = held_;
        lock.unlock();
        held_ = std::make_shared<Held>(shared->map->clone());
    } else if (held_->encoded) {
        registry.remove(held_);
        held_->encoded.reset();
    }
    // What other copies read before they let go comes before what is written now:
    // dropping a reference synchronizes with those that were dropped before.
    std::shared_ptr<Held>(held_).reset();
    return *held_->map;
}

template <int Dim>
void SharedStorage<Dim>::clear() {
    if (held_.use_count() == 1)
        writable().clear();
    else
        held_ = std::make_shared<Held>(held_->map->emptyLike(held_->map->geometry()));
}

template <int Dim>
std::shared_ptr<const typename SharedStorage<Dim>::Bytes> SharedStorage<Dim>::encoded() const {
    Registry& registry = Registry::instance();
    {
        const std::lock_guard<std::mutex> lock(registry.mutex);
        if (held_->encoded) return held_->encoded;
    }
    auto bytes = std::make_shared<const Bytes>(encodeCells(*held_->map));
    const std::lock_guard<std::mutex> lock(registry.mutex);
    if (!held_->encoded) {
        held_->encoded = std::move(bytes);
        registry.add(held_);
    }
    return held_->encoded;
}

template class SharedStorage<2>;
template class SharedStorage<3>;

}  // namespace superray
