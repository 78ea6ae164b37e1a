// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/octomap_input.h>
#include <superray/storage/block_grid.h>
#include <superray/storage/map_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace superray {
namespace {

constexpr int kTreeDepth = 16;
/// In a dense map: a value, and whether it is known [bytes].
constexpr std::uint64_t kBytesOfCell = 5;

struct Header {
    CellValues values = CellValues::logOdds;
    std::uint64_t nodes = 0;
    double resolution = 0;
    bool hasColours = false;
};

/// A leaf covers edge^3 cells from `lowest` on.
struct Leaf {
    Cell<3> lowest;
    std::int32_t edge;
    float value;
};

/// The bytes of a file, read front to back.
class Bytes {
 public:
    Bytes(const std::string& path, std::uint64_t most) : path_(path) {
        std::error_code error;
        const auto status = std::filesystem::status(path, error);
        if (!std::filesystem::exists(status)) throw MapFileError(path + ": no such file");
        if (!std::filesystem::is_regular_file(status))
            throw MapFileError(path + ": is not a regular file");
        std::ifstream file(path, std::ios::binary);
        if (!file) throw MapFileError(path + ": cannot be opened for reading");
        const auto size = std::filesystem::file_size(path);
        if (size > most)
            throw MapFileError(path + ": has " + std::to_string(size) +
                               " bytes; OctoMap files of at most " + std::to_string(most) +
                               " are read");
        data_.resize(size);
        file.read(data_.data(), static_cast<std::streamsize>(size));
        if (file.gcount() != static_cast<std::streamsize>(size))
            throw MapFileError(path + ": cannot be read");
    }
    std::uint64_t size() const { return data_.size(); }

    [[noreturn]] void fail(const std::string& why) const {
        throw MapFileError(path_ + ": is not a whole OctoMap OcTree file: " + why);
    }

    /// It may be whole: nothing is said of that.
    [[noreturn]] void failAsTooLarge(std::uint64_t mostCells, std::uint64_t ofAll) const {
        throw MapFileError(path_ + ": its pruned nodes stand for more than " +
                           std::to_string(mostCells) +
                           " cells, the most that are read of a file of " +
                           std::to_string(size()) + " bytes; SUPERRAY_MAP_MEGABYTES=N allows " +
                           std::to_string((1u << 20) / kBytesOfCell) +
                           " cells per N, at most " + std::to_string(ofAll));
    }

    template <class T>
    T take() {
        T value;
        if (data_.size() - at_ < sizeof value) fail("it ends early");
        std::memcpy(&value, data_.data() + at_, sizeof value);
        at_ += sizeof value;
        return value;
    }

    /// The next line, without its end.
    std::string takeLine() {
        const auto end = data_.find('\n', at_);
        if (end == std::string::npos) fail("its header has no line 'data'");
        std::string line = data_.substr(at_, end - at_);
        at_ = end + 1;
        return line;
    }

    std::size_t left() const { return data_.size() - at_; }

 private:
    std::string path_, data_;
    std::size_t at_ = 0;
};

Header readHeader(Bytes& bytes) {
    Header header;
    const std::string magic = bytes.left() > 0 ? bytes.takeLine() : "";
    if (magic.rfind("# Octomap OcTree binary file", 0) == 0)
        header.values = CellValues::occupancy;
    else if (magic.rfind("# Octomap OcTree file", 0) != 0)
        bytes.fail("its first line is not '# Octomap OcTree file' or '... binary file'");
    std::string id;
    for (std::string line = bytes.takeLine(); line != "data"; line = bytes.takeLine()) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream words(line);
        words.imbue(std::locale::classic());
        std::string key;
        words >> key;
        if (key == "id") words >> id;
        if (key == "size") words >> header.nodes;
        if (key == "res") words >> header.resolution;
        if (!words) bytes.fail("its header line '" + line + "' cannot be understood");
    }
    header.hasColours = id == "ColorOcTree";
    if (id != "OcTree" && !header.hasColours)
        bytes.fail("its tree type is '" + id + "', not 'OcTree' or 'ColorOcTree'");
    if (!isResolution(header.resolution))
        bytes.fail("its resolution must be " + std::string(kResolutionRule));
    return header;
}

/// Walks the nodes of a file, depth first, children in order of their index.
class LeafReader {
 public:
    LeafReader(Bytes& bytes, bool hasColours, const OctomapLimits& limits)
        : bytes_(bytes),
          hasColours_(hasColours),
          limits_(limits),
          mostCells_(std::min(
              limits.cells, std::max(limits.cellsOfAnyFile + limits.cellsPerByte * bytes.size(),
                                     mapBytesOfEnvironment().value_or(0) / kBytesOfCell))) {}

    /// .ot: float32 log-odds, three bytes of colour in a ColorOcTree, a bit per child.
    void readNode(const Cell<3>& lowest, int depth) {
        ++nodes_;
        const auto value = bytes_.take<float>();
        if (hasColours_) bytes_.take<std::array<std::uint8_t, 3>>();
        const auto children = bytes_.take<std::uint8_t>();
        if (children == 0) return addLeaf(lowest, depth, value);
        forEachChild(lowest, depth, [&](int child, const Cell<3>& childLowest) {
            if ((children >> child) & 1) readNode(childLowest, depth + 1);
        });
    }

    /// .bt: two bits per child of an inner node; bit 0 is `free` and bit 1
    /// `occupied`, both are set for an inner node.
    void readBinaryNode(const Cell<3>& lowest, int depth) {
        ++nodes_;
        const auto children = bytes_.take<std::uint16_t>();
        std::uint8_t inner = 0;
        forEachChild(lowest, depth, [&](int child, const Cell<3>& childLowest) {
            const int state = (children >> (2 * child)) & 3;
            if (state == 3) inner = static_cast<std::uint8_t>(inner | (1 << child));
            if (state != 1 && state != 2) return;
            ++nodes_;
            addLeaf(childLowest, depth + 1, state == 1 ? -1.0f : 1.0f);
        });
        forEachChild(lowest, depth, [&](int child, const Cell<3>& childLowest) {
            if ((inner >> child) & 1) readBinaryNode(childLowest, depth + 1);
        });
    }

    std::uint64_t nodes() const { return nodes_; }
    std::uint64_t cells() const { return cells_; }
    const std::vector<Leaf>& leaves() const { return leaves_; }

 private:
    static std::int32_t edgeAt(int depth) { return std::int32_t{1} << (kTreeDepth - depth); }

    template <class Visit>
    void forEachChild(const Cell<3>& lowest, int depth, const Visit& visit) {
        if (depth == kTreeDepth) bytes_.fail("it is deeper than 16 levels");
        const std::int32_t edge = edgeAt(depth + 1);
        for (int child = 0; child < 8; ++child) {
            Cell<3> c = lowest;
            for (std::size_t axis = 0; axis < 3; ++axis)
                if ((child >> axis) & 1) c[axis] += edge;
            visit(child, c);
        }
    }

    void addLeaf(const Cell<3>& lowest, int depth, float value) {
        if (!std::isfinite(value)) bytes_.fail("a cell's log-odds is not finite");
        const auto edge = static_cast<std::uint64_t>(edgeAt(depth));
        cells_ += edge * edge * edge;
        if (cells_ > mostCells_) bytes_.failAsTooLarge(mostCells_, limits_.cells);
        leaves_.push_back({lowest, edgeAt(depth), value});
    }

    Bytes& bytes_;
    bool hasColours_;
    OctomapLimits limits_;
    std::uint64_t mostCells_;
    std::uint64_t nodes_ = 0, cells_ = 0;
    std::vector<Leaf> leaves_;
};

template <class Visit>
void forEachStep(const Leaf& leaf, std::int32_t step, const Visit& visit) {
    for (std::int32_t z = 0; z < leaf.edge; z += step)
        for (std::int32_t y = 0; y < leaf.edge; y += step)
            for (std::int32_t x = 0; x < leaf.edge; x += step)
                visit(Cell<3>{leaf.lowest[0] + x, leaf.lowest[1] + y, leaf.lowest[2] + z});
}

void fill(const Leaf& leaf, OccupancyMap<3>& map) {
    if (leaf.edge < kBlockEdge) {
        forEachStep(leaf, 1, [&](const Cell<3>& cell) { map.setLogOdds(cell, leaf.value); });
        return;
    }
    const std::vector<float> values(kBlockCells<3>, leaf.value);
    BlockMask<3> all;
    for (auto& word : all.words) word = ~std::uint64_t{0};
    forEachStep(leaf, kBlockEdge, [&](const Cell<3>& cell) {
        map.setBlock({blockOf<3>(cell), values.data(), all});
    });
}

}  // namespace

bool isOctomapFile(const std::string& path) {
    constexpr char kMagic[] = "# Octomap OcTree";
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return false;
    std::ifstream file(path, std::ios::binary);
    std::string start(sizeof kMagic - 1, '\0');
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    return file && start == kMagic;
}

OctomapFile loadOctomapFile(const std::string& path, const OctomapLimits& limits) {
    Bytes bytes(path, limits.fileBytes);
    const Header header = readHeader(bytes);
    LeafReader reader(bytes, header.hasColours, limits);
    if (header.nodes > 0) {
        const Cell<3> lowest{-kCellLimit, -kCellLimit, -kCellLimit};
        if (header.values == CellValues::occupancy)
            reader.readBinaryNode(lowest, 0);
        else
            reader.readNode(lowest, 0);
    }
    if (reader.nodes() != header.nodes)
        bytes.fail("it announces " + std::to_string(header.nodes) + " nodes but holds " +
                   std::to_string(reader.nodes()));
    if (bytes.left() > 0)
        bytes.fail("it goes on for " + std::to_string(bytes.left()) + " bytes after its tree");
    OctomapFile file;
    file.values = header.values;
    // A .bt file of a ColorOcTree has none.
    if (header.hasColours && header.values == CellValues::logOdds)
        file.note = "the colours of the ColorOcTree are dropped";
    file.map = std::make_unique<BlockGrid<3>>(CellGeometry<3>(header.resolution));
    for (const Leaf& leaf : reader.leaves()) fill(leaf, *file.map);
    return file;
}

}  // namespace superray
