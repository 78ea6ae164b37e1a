#pragma once
// Where the rays of a scan end: a block of a dense directory, and a cell in it.

#include <superray/core/ray_bundle.h>

#include "block_directory.h"

#include <vector>

namespace superray {

template <int Dim>
class EndAddresses {
 public:
    void resize(std::size_t n) {
        blocks_.resize(n);
        locals_.resize(n);
    }
    /// Index of the end cell's block in the directory (BlockDirectory::indexOf).
    std::uint32_t block(std::size_t ray) const { return blocks_[ray]; }
    /// Index of the end cell in its block.
    std::uint32_t local(std::size_t ray) const { return locals_[ray]; }

    std::uint32_t* blocks() { return blocks_.data(); }
    std::uint16_t* locals() { return locals_.data(); }

 private:
    std::vector<std::uint32_t> blocks_;
    std::vector<std::uint16_t> locals_;
};

/// Of the rays [begin, end), to out from 0 on. \pre the directory is dense and
/// covers the scan; out.resize(end - begin) was called
template <int Dim>
using FindEnds = void (*)(const RayBundle<Dim>& rays, std::size_t begin, std::size_t end,
                          const BlockDirectory<Dim>& directory, EndAddresses<Dim>& out);

}  // namespace superray
