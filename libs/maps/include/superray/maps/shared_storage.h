// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file shared_storage.h
/// Cells that copies of a map have in common until one of them is written to.

#include <superray/storage/map_file.h>
#include <superray/storage/occupancy_map.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace superray {

/// Copies cost nothing; the first write to one of them copies the cells.
///
/// MRPT copies maps also by writing them to a stream and reading that back, so
/// the bytes are made once per state of the cells, and reading bytes whose cells
/// are still in memory shares those.
///
/// Copies may be used in different threads, as if they were deep.
template <int Dim>
class SharedStorage {
 public:
    using Bytes = std::vector<std::uint8_t>;

    /// \pre map
    explicit SharedStorage(std::unique_ptr<OccupancyMap<Dim>> map);

    /// Contents from encoded() bytes.
    /// \throws MapFileError, MemoryLimitError
    static SharedStorage decoded(StorageType type, const CellGeometry<Dim>& geometry,
                                 const Bytes& bytes,
                                 const MapFileLimits& limits = MapFileLimits::ofThisMachine());

    const OccupancyMap<Dim>& operator*() const { return *held_->map; }
    const OccupancyMap<Dim>* operator->() const { return held_->map.get(); }
    /// Cells of this copy alone. Valid, like the references that the operators
    /// return, until the next copy is made of this object or it is assigned to.
    OccupancyMap<Dim>& writable();
    /// Removes all cells; does not copy them before.
    void clear();

    bool sharesWith(const SharedStorage& other) const { return held_ == other.held_; }

    /// encodeCells() of the contents, kept until they change.
    std::shared_ptr<const Bytes> encoded() const;

 private:
    struct Held {
        explicit Held(std::unique_ptr<OccupancyMap<Dim>> m) : map(std::move(m)) {}
        std::unique_ptr<OccupancyMap<Dim>> map;
        std::shared_ptr<const Bytes> encoded;  ///< guarded by the registry's lock
    };
    class Registry;
    std::shared_ptr<Held> held_;
};

extern template class SharedStorage<2>;
extern template class SharedStorage<3>;

}  // namespace superray
