// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/loaded_observation.h"

#include <cstddef>
#include <mutex>
#include <unordered_map>

#include "sensors/external_file.h"

namespace superray {

/// The holders of one observation.
struct LoadedObservation::Readers {
    std::size_t count = 0;  ///< guarded by the registry's lock
    std::mutex loading;     ///< held while the observation is loaded or unloaded
    // Guarded by `loading`:
    bool ready = false;
    bool unloadAfter = false;
};

/// The observations that are being read now. A thread never waits for `loading` while
/// it holds the lock of the registry: reading a file does not stop other observations.
class LoadedObservation::Registry {
 public:
    // Never destroyed: threads may read until the very end of the process.
    static Registry& instance() {
        static auto* const registry = new Registry;
        return *registry;
    }

    std::shared_ptr<Readers> join(const mrpt::obs::CObservation& observation) {
        const std::lock_guard<std::mutex> lock(mutex_);
        auto& readers = readers_[&observation];
        if (!readers) readers = std::make_shared<Readers>();
        ++readers->count;
        return readers;
    }

    /// \return whether nobody is left; the entry remains, for those who join meanwhile
    bool leave(Readers& readers) {
        const std::lock_guard<std::mutex> lock(mutex_);
        return --readers.count == 0;
    }

    /// Forgets the observation, unless somebody joined since.
    void forget(const mrpt::obs::CObservation& observation, const Readers& readers) {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto found = readers_.find(&observation);
        if (found != readers_.end() && found->second.get() == &readers && readers.count == 0)
            readers_.erase(found);
    }

 private:
    std::mutex mutex_;
    std::unordered_map<const mrpt::obs::CObservation*, std::shared_ptr<Readers>> readers_;
};

LoadedObservation::LoadedObservation(const mrpt::obs::CObservation& observation,
                                     const std::function<bool()>& isLoaded)
    : observation_(observation), readers_(Registry::instance().join(observation)) {
    try {
        const std::lock_guard<std::mutex> lock(readers_->loading);
        if (readers_->ready) return;
        readers_->unloadAfter = !isLoaded();
        loadExternalData(observation_);
        readers_->ready = true;
    } catch (...) {
        release();
        throw;
    }
}

LoadedObservation::~LoadedObservation() {
    release();
}

void LoadedObservation::release() noexcept {
    Registry& registry = Registry::instance();
    {
        const std::lock_guard<std::mutex> lock(readers_->loading);
        if (!registry.leave(*readers_)) return;
        if (readers_->ready && readers_->unloadAfter) observation_.unload();
        readers_->ready = false;
    }
    registry.forget(observation_, *readers_);
}

}  // namespace superray
