// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file surface_statistics.h
/// Where exactly the surface lies in a cell: moments of the end points in it.

#include <superray/core/block.h>
#include <superray/core/ray_bundle.h>
#include <superray/storage/block_window.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace superray {

/// The surface in one cell.
template <int Dim>
struct SurfacePatch {
    Point<Dim> mean;    ///< of the end points in the cell [m, map frame]
    Point<Dim> normal;  ///< unit length, either side; zero where no plane is known
    /// 1 - thickness / width of the surface in the cell and its neighbours: 1 for
    /// a thin plane, near 0 for a heap of points. 0 where no plane is known.
    double planarity = 0;
    std::uint32_t points = 0;  ///< end points in the cell

    /// The point of the patch that is nearest to `p`: its projection on the plane
    /// (in 2D: line) through the mean, or the mean where no plane is known.
    Point<Dim> footPoint(const Point<Dim>& p) const {
        if (planarity <= 0) return mean;
        return p - normal.dot(p - mean) * normal;
    }
};

/// Number, mean and covariance of the end points in each cell, kept as sums, so
/// that scans may come in any order. Normals are those of a cell and its direct
/// neighbours together, which makes them steadier than the points of one cell.
///
/// Reading may go on in several threads, writing in one alone.
template <int Dim>
class SurfaceStatistics {
 public:
    /// Fewer points, in a cell and its neighbours, do not make a plane.
    static constexpr std::uint32_t kPlanePoints = Dim == 3 ? 6 : 4;

    explicit SurfaceStatistics(const CellGeometry<Dim>& geometry) : geometry_(geometry) {}

    /// Adds the hits of a scan. \throws std::bad_alloc; then all is as before
    void add(const RayBundle<Dim>& rays) { Addition(*this, rays, nullptr).commit(); }

    /// The hits of a scan on their way into the statistics, which must not be used or
    /// changed in between.
    class Addition {
     public:
        /// Takes all the memory that is needed.
        /// \param window null, or what hits must be in
        /// \throws std::bad_alloc; then the statistics are as before
        Addition(SurfaceStatistics& statistics, const RayBundle<Dim>& rays,
                 const BlockWindow<Dim>* window);
        /// Without commit(), the statistics are as before.
        ~Addition();
        Addition(const Addition&) = delete;
        Addition& operator=(const Addition&) = delete;
        void commit();  ///< cannot fail

     private:
        void removeNewCells();
        void findChanged(const BlockWindow<Dim>* window);

        SurfaceStatistics& statistics_;
        const RayBundle<Dim>& rays_;
        const std::size_t sizeBefore_;
        std::vector<std::uint32_t> changed_;  ///< numbers of cells
        bool committed_ = false;
    };

    /// Removes the cells outside a window; does not fail. Patches beside them stay as they
    /// are until a point falls in or beside their cells.
    /// \param blocks all blocks outside that may have some
    void forget(const std::vector<BlockKey<Dim>>& blocks, const BlockWindow<Dim>& window);
    /// The same without being told the blocks.
    void forgetOutside(const BlockWindow<Dim>& window);

    /// The patch in a cell; nullptr if no end point fell into it.
    const SurfacePatch<Dim>* patch(const Cell<Dim>& cell) const {
        const std::uint32_t number = find(cell);
        return number == kNone ? nullptr : &patches_[number];
    }

    const CellGeometry<Dim>& geometry() const { return geometry_; }
    std::size_t size() const { return moments_.size(); }
    std::size_t memoryBytes() const;
    /// The most that memoryBytes() can be with so many cells more.
    std::size_t memoryBytesAtMost(std::size_t cells) const;
    /// Cells of hits that have no patch yet.
    std::size_t newCells(const RayBundle<Dim>& rays) const;

 private:
    using Matrix = Eigen::Matrix<double, Dim, Dim>;

    // Relative to the centre of the cell, for precision far from the origin.
    struct Moments {
        Cell<Dim> cell;
        std::uint32_t points = 0;
        std::uint32_t scan = 0;  ///< in which the patch was last made
        Point<Dim> sum = Point<Dim>::Zero();
        Matrix squares = Matrix::Zero();
    };

    /// Open addressing with linear probing, and only keys and numbers in the
    /// table: most of the neighbours that are looked for do not exist.
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};
    struct Slot {
        std::uint64_t key = kFree;
        std::uint32_t number = kNone;
    };

    /// 16 bits per axis: all addressable cells (kCellLimit).
    static std::uint64_t keyOf(const Cell<Dim>& cell) {
        std::uint64_t key = 0;
        for (int a = 0; a < Dim; ++a)
            key = (key << 16) | static_cast<std::uint16_t>(cell[a] + kCellLimit);
        return key;
    }
    /// Where the key goes if nothing is there. \pre !slots_.empty()
    std::size_t home(std::uint64_t key) const {
        const std::uint64_t h = (key ^ (key >> 29)) * 0x9E3779B97F4A7C15ull;
        return static_cast<std::size_t>(h >> 32) & (slots_.size() - 1);
    }
    /// Where the key is, or where it would go. \pre !slots_.empty()
    std::size_t position(std::uint64_t key) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t i = home(key);
        while (slots_[i].key != key && slots_[i].key != kFree) i = (i + 1) & mask;
        return i;
    }
    /// \return kNone also for cells that cannot be addressed
    std::uint32_t find(const Cell<Dim>& cell) const {
        if (slots_.empty()) return kNone;
        for (int a = 0; a < Dim; ++a)
            if (cell[a] < -kCellLimit || cell[a] >= kCellLimit) return kNone;
        return slots_[position(keyOf(cell))].number;
    }
    std::uint32_t findOrInsert(const Cell<Dim>& cell);
    void remove(std::uint32_t number);
    SurfacePatch<Dim> makePatch(const Moments& moments) const;

    CellGeometry<Dim> geometry_;
    std::vector<Slot> slots_;  ///< none, or a power of two
    std::vector<Moments> moments_;
    std::vector<SurfacePatch<Dim>> patches_;
    std::uint32_t scans_ = 0;
};

extern template class SurfaceStatistics<2>;
extern template class SurfaceStatistics<3>;

}  // namespace superray
