#pragma once
/// \file object_pool.h
/// Memory for many small objects of one type, addressed by pointer.

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace superray {

/// Slots for objects of type T, whose destructors never run. Released slots are
/// used again; memory goes back only with the pool.
template <typename T>
class ObjectPool {
 public:
    ObjectPool() = default;
    ObjectPool(const ObjectPool&) = delete;
    ObjectPool& operator=(const ObjectPool&) = delete;

    /// Uninitialised memory for one object.
    T* allocate() {
        if (free_ != nullptr) {
            Slot* const slot = free_;
            free_ = slot->next;
            return reinterpret_cast<T*>(slot);
        }
        if (next_ == end_) {
            chunks_.emplace_back(new Slot[kChunk]);
            next_ = chunks_.back().get();
            end_ = next_ + kChunk;
        }
        return reinterpret_cast<T*>(next_++);
    }
    void release(T* object) { free_ = new (object) Slot{free_}; }

    void swap(ObjectPool& o) {
        chunks_.swap(o.chunks_);
        std::swap(free_, o.free_);
        std::swap(next_, o.next_);
        std::swap(end_, o.end_);
    }
    void clear() {
        chunks_.clear();
        free_ = next_ = end_ = nullptr;
    }

 private:
    union Slot {
        Slot* next;
        std::aligned_storage_t<sizeof(T), alignof(T)> object;
    };
    static constexpr std::size_t kChunk = (std::size_t{1} << 16) / sizeof(Slot);

    std::vector<std::unique_ptr<Slot[]>> chunks_;
    Slot* free_ = nullptr;
    Slot* next_ = nullptr;
    Slot* end_ = nullptr;
};

}  // namespace superray
