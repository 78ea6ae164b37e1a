// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/grow.h>
#include <superray/core/detail/linear_probing.h>
#include <superray/maps/surface_statistics.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <vector>

namespace superray {
namespace {

/// Calls f(neighbour, offset) for a cell and its 3^Dim - 1 neighbours.
template <int Dim, class F>
void forEachNear(const Cell<Dim>& cell, F f) {
    Cell<Dim> offset;
    offset.fill(-1);
    for (;;) {
        Cell<Dim> c;
        for (int a = 0; a < Dim; ++a) c[a] = cell[a] + offset[a];
        f(c, offset);
        int a = 0;
        while (a < Dim && offset[a] == 1) offset[a++] = -1;
        if (a == Dim) return;
        ++offset[a];
    }
}

}  // namespace

template <int Dim>
std::uint32_t SurfaceStatistics<Dim>::findOrInsert(const Cell<Dim>& cell) {
    if (2 * (moments_.size() + 1) > slots_.size()) {
        std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
        old.swap(slots_);
        for (const Slot& slot : old)
            if (slot.key != kFree) slots_[position(slot.key)] = slot;
    }
    const std::uint64_t key = keyOf(cell);
    Slot& slot = slots_[position(key)];
    if (slot.key == kFree) {
        detail::growBy(moments_, 1);
        detail::growBy(patches_, 1);  // nothing fails from here on
        slot = {key, static_cast<std::uint32_t>(moments_.size())};
        moments_.emplace_back();
        moments_.back().cell = cell;
        patches_.emplace_back();
    }
    return slot.number;
}

/// The last cell takes its number.
template <int Dim>
void SurfaceStatistics<Dim>::remove(std::uint32_t number) {
    detail::emptySlot(
        slots_, position(keyOf(moments_[number].cell)),
        [](const Slot& s) { return s.key == kFree; },
        [&](const Slot& s) { return home(s.key); });
    if (number + 1 != moments_.size()) {
        moments_[number] = moments_.back();
        patches_[number] = patches_.back();
        slots_[position(keyOf(moments_[number].cell))].number = number;
    }
    moments_.pop_back();
    patches_.pop_back();
}

template <int Dim>
void SurfaceStatistics<Dim>::forget(const std::vector<BlockKey<Dim>>& blocks,
                                    const BlockWindow<Dim>& window) {
    if (blocks.size() * kBlockCells<Dim> >= moments_.size()) return forgetOutside(window);
    for (const BlockKey<Dim>& block : blocks)
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (const auto number = find(cellInBlock<Dim>(block, i)); number != kNone)
                remove(number);
}

template <int Dim>
void SurfaceStatistics<Dim>::forgetOutside(const BlockWindow<Dim>& window) {
    for (std::size_t n = moments_.size(); n-- > 0;)
        if (!window.holds(blockOf<Dim>(moments_[n].cell)))
            remove(static_cast<std::uint32_t>(n));
}

template <int Dim>
std::size_t SurfaceStatistics<Dim>::newCells(const RayBundle<Dim>& rays) const {
    std::unordered_set<std::uint64_t> cells;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (rays.kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = geometry_.cellOf(rays.end(i));
        if (find(cell) == kNone) cells.insert(keyOf(cell));
    }
    return cells.size();
}

template <int Dim>
std::size_t SurfaceStatistics<Dim>::memoryBytesAtMost(std::size_t cells) const {
    const std::size_t size = moments_.size() + cells;
    std::size_t slots = slots_.size();
    while (cells > 0 && 2 * (size + 1) > slots) slots = slots == 0 ? 64 : 2 * slots;
    const auto grown = [&](std::size_t capacity) {
        return size <= capacity ? capacity : 2 * size;
    };
    return std::max(slots, slots_.capacity()) * sizeof(Slot) +
           grown(moments_.capacity()) * sizeof(Moments) +
           grown(patches_.capacity()) * sizeof(SurfacePatch<Dim>);
}

template <int Dim>
SurfaceStatistics<Dim>::Addition::Addition(SurfaceStatistics& statistics,
                                           const RayBundle<Dim>& rays,
                                           const BlockWindow<Dim>* window)
    : statistics_(statistics), rays_(rays), sizeBefore_(statistics.size()) {
    try {
        findChanged(window);
    } catch (...) {
        removeNewCells();
        throw;
    }
}

template <int Dim>
SurfaceStatistics<Dim>::Addition::~Addition() {
    if (!committed_) removeNewCells();
}

template <int Dim>
void SurfaceStatistics<Dim>::Addition::removeNewCells() {
    for (std::size_t n = statistics_.size(); n-- > sizeBefore_;)
        statistics_.remove(static_cast<std::uint32_t>(n));
}

/// Makes the cells of the hits.
template <int Dim>
void SurfaceStatistics<Dim>::Addition::findChanged(const BlockWindow<Dim>* window) {
    SurfaceStatistics& s = statistics_;
    ++s.scans_;
    const auto note = [&](std::uint32_t number) {
        if (s.moments_[number].scan == s.scans_) return;
        s.moments_[number].scan = s.scans_;
        changed_.push_back(number);
    };
    for (std::size_t i = 0; i < rays_.size(); ++i) {
        if (rays_.kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = s.geometry_.cellOf(rays_.end(i));
        if (window && !window->holds(blockOf<Dim>(cell))) continue;
        note(s.findOrInsert(cell));
    }
    // A cell that changes also changes the normals of its neighbours, once each.
    const std::size_t touched = changed_.size();
    for (std::size_t i = 0; i < touched; ++i)
        forEachNear<Dim>(s.moments_[changed_[i]].cell,
                         [&](const Cell<Dim>& c, const Cell<Dim>&) {
                             if (const auto n = s.find(c); n != kNone) note(n);
                         });
}

template <int Dim>
void SurfaceStatistics<Dim>::Addition::commit() {
    SurfaceStatistics& s = statistics_;
    committed_ = true;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
        if (rays_.kind(i) != RayEnd::hit) continue;
        const Point<Dim>& p = rays_.end(i);
        const Cell<Dim> cell = s.geometry_.cellOf(p);
        const std::uint32_t number = s.find(cell);
        if (number == kNone) continue;  // outside the window
        Moments& moments = s.moments_[number];
        const Point<Dim> offset = p - s.geometry_.center(cell);
        ++moments.points;
        moments.sum += offset;
        moments.squares += offset * offset.transpose();
    }
    for (const std::uint32_t number : changed_)
        s.patches_[number] = s.makePatch(s.moments_[number]);
}

template <int Dim>
SurfacePatch<Dim> SurfaceStatistics<Dim>::makePatch(const Moments& own) const {
    std::uint32_t points = 0;
    Point<Dim> sum = Point<Dim>::Zero();
    Matrix squares = Matrix::Zero();
    forEachNear<Dim>(own.cell, [&](const Cell<Dim>& c, const Cell<Dim>& offset) {
        const std::uint32_t number = find(c);
        if (number == kNone) return;
        const Moments& near = moments_[number];
        Point<Dim> shift;
        for (int a = 0; a < Dim; ++a) shift[a] = offset[a] * geometry_.resolution();
        const double n = near.points;
        points += near.points;
        sum += near.sum + n * shift;
        squares += near.squares + shift * near.sum.transpose() + near.sum * shift.transpose() +
                   n * shift * shift.transpose();
    });
    SurfacePatch<Dim> patch;
    patch.points = own.points;
    patch.mean = geometry_.center(own.cell) + own.sum / own.points;
    patch.normal.setZero();
    if (points < kPlanePoints) return patch;
    const Point<Dim> mean = sum / points;
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(squares / points -
                                                       mean * mean.transpose());
    const double thickness = std::max(0.0, solver.eigenvalues()[0]);
    const double width = solver.eigenvalues()[1];
    // Points on a line (in 2D: in one spot) do not say where the plane is.
    if (!(width > 1e-6 * geometry_.resolution() * geometry_.resolution())) return patch;
    patch.normal = solver.eigenvectors().col(0);
    patch.planarity = 1 - std::sqrt(thickness / width);
    return patch;
}

template <int Dim>
std::size_t SurfaceStatistics<Dim>::memoryBytes() const {
    return slots_.capacity() * sizeof(Slot) + moments_.capacity() * sizeof(Moments) +
           patches_.capacity() * sizeof(SurfacePatch<Dim>);
}

template class SurfaceStatistics<2>;
template class SurfaceStatistics<3>;

}  // namespace superray
