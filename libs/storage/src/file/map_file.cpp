// SPDX-License-Identifier: BSD-3-Clause
// The container: see doc/file_format.md, "Container".

#include <superray/storage/map_file.h>

#include <superray/storage/atomic_file.h>
#include <superray/storage/block_grid.h>
#include <superray/storage/octree.h>
#include <superray/storage/quadtree.h>

#include "file/byte_io.h"
#include "file/deflate_stream.h"
#include "file/input_file.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace superray {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'S', 'R', 'M', 'A', 'P', '\r', '\n'};
constexpr std::uint32_t kFormatVersion = 1;
constexpr std::size_t kPreamble = 28;       // magic, version, sections, file size, checksum
constexpr std::size_t kSectionHeader = 16;  // tag, length, checksum
constexpr char kHeadTag[] = "HEAD", kOptionsTag[] = "OPTS", kCellsTag[] = "CELL";

/// What is wrong with a header; nothing if it is valid.
std::optional<std::string> problemOf(const MapFileHeader& h) {
    if (h.className.empty()) return "the class name is empty";
    if (h.dimension != 2 && h.dimension != 3)
        return "dimension " + std::to_string(h.dimension) + " is not 2 or 3";
    if (isResolution(h.resolution)) return std::nullopt;
    return "resolution " + metresText(h.resolution) + " is not " + kResolutionRule;
}

/// Checksum of a section: its tag, length and contents.
std::uint32_t sectionCrc(const std::uint8_t* tagAndLength, const std::uint8_t* data,
                         std::size_t size) {
    return crc32Of(data, size, crc32Of(tagAndLength, kSectionHeader - 4));
}

void putSection(Bytes& out, const char* tag, const Bytes& data) {
    const std::size_t start = out.size();
    out.insert(out.end(), tag, tag + 4);
    put(out, std::uint64_t{data.size()});
    put(out, sectionCrc(out.data() + start, data.data(), data.size()));
    out.insert(out.end(), data.begin(), data.end());
}

Bytes encodeHead(const MapFileHeader& h) {
    Bytes out;
    put(out, static_cast<std::uint8_t>(h.dimension));
    put(out, h.resolution);
    out.insert(out.end(), h.className.begin(), h.className.end());
    return out;
}

/// Walks over the sections of a file, each validated.
class SectionReader {
 public:
    SectionReader(const std::uint8_t* data, std::size_t size, const std::string& name)
        : data_(data), size_(size), name_(name) {}

    MapFile read() {
        const std::uint32_t sections = readPreamble();
        for (std::uint32_t s = 0; s < sections; ++s) readSection();
        if (at_ != size_) fail(std::to_string(size_ - at_) + " bytes after the last section");
        const Bytes head = require(head_, kHeadTag);
        const Bytes options = require(options_, kOptionsTag);
        MapFile file;
        decodeHead(head, file.header);
        file.header.options.assign(options.begin(), options.end());
        file.cells = require(cells_, kCellsTag);
        return file;
    }

    /// Looks at the first kPreamble bytes only. \return the number of sections
    std::uint32_t readPreamble() {
        if (size_ < kPreamble) fail("too short for a map file");
        if (!std::equal(kMagic.begin(), kMagic.end(), data_)) fail("not a superray map file");
        if (const auto version = get<std::uint32_t>(data_ + 8); version != kFormatVersion)
            fail("format version " + std::to_string(version) + "; this program reads version " +
                 std::to_string(kFormatVersion));
        if (get<std::uint32_t>(data_ + kPreamble - 4) != crc32Of(data_, kPreamble - 4))
            fail("checksum mismatch in the preamble");
        if (const auto declared = get<std::uint64_t>(data_ + 16); declared != size_)
            fail("the file has " + std::to_string(size_) + " bytes, not the declared " +
                 std::to_string(declared));
        at_ = kPreamble;
        return get<std::uint32_t>(data_ + 12);
    }

 private:
    struct Section {
        std::size_t begin, size;
    };

    [[noreturn]] void fail(const std::string& what) const {
        throw MapFileError(name_ + ": at byte " + std::to_string(at_) + ": " + what);
    }

    void readSection() {
        if (size_ - at_ < kSectionHeader) fail("section header is cut off");
        const std::uint8_t* header = data_ + at_;
        const std::string tag(header, header + 4);
        const auto length = get<std::uint64_t>(header + 4);
        if (length > size_ - at_ - kSectionHeader)
            fail("section '" + tag + "' of " + std::to_string(length) +
                 " bytes is longer than the rest of the file");
        const auto size = static_cast<std::size_t>(length);
        if (get<std::uint32_t>(header + 12) !=
            sectionCrc(header, header + kSectionHeader, size))
            fail("checksum mismatch in section '" + tag + "'");
        if (std::optional<Section>* known = sectionOf(tag)) {
            if (*known) fail("second section '" + tag + "'");
            *known = Section{at_ + kSectionHeader, size};
        }  // others are of a later minor revision: skipped
        at_ += kSectionHeader + size;
    }

    std::optional<Section>* sectionOf(const std::string& tag) {
        if (tag == kHeadTag) return &head_;
        if (tag == kOptionsTag) return &options_;
        if (tag == kCellsTag) return &cells_;
        return nullptr;
    }

    Bytes require(const std::optional<Section>& s, const char* tag) const {
        if (!s) fail(std::string("section '") + tag + "' is missing");
        return Bytes(data_ + s->begin, data_ + s->begin + s->size);
    }

    void decodeHead(const Bytes& head, MapFileHeader& h) const {
        if (head.size() < 9) fail("section 'HEAD' is too short");
        h.dimension = head[0];
        h.resolution = get<double>(head.data() + 1);
        h.className.assign(head.begin() + 9, head.end());
        if (const auto problem = problemOf(h)) fail("section 'HEAD': " + *problem);
    }

    const std::uint8_t* data_;
    std::size_t size_;
    const std::string& name_;
    std::size_t at_ = 0;
    std::optional<Section> head_, options_, cells_;
};

}  // namespace

template <>
std::unique_ptr<OccupancyMap<2>> makeStorage<2>(StorageType type,
                                                const CellGeometry<2>& geometry) {
    if (type == StorageType::tree) return std::make_unique<Quadtree>(geometry);
    return std::make_unique<BlockGrid<2>>(geometry);
}

template <>
std::unique_ptr<OccupancyMap<3>> makeStorage<3>(StorageType type,
                                                const CellGeometry<3>& geometry) {
    if (type == StorageType::tree) return std::make_unique<Octree>(geometry);
    return std::make_unique<BlockGrid<3>>(geometry);
}

void saveMapFile(const std::string& path, const MapFileHeader& header,
                 const std::vector<std::uint8_t>& cells) {
    if (const auto problem = problemOf(header))
        throw MapFileError("cannot save " + path + ": " + *problem);
    const Bytes head = encodeHead(header);
    const Bytes options(header.options.begin(), header.options.end());
    Bytes file(kMagic.begin(), kMagic.end());
    put(file, kFormatVersion);
    put(file, std::uint32_t{3});
    put(file, std::uint64_t{kPreamble + 3 * kSectionHeader + head.size() + options.size() +
                            cells.size()});
    put(file, crc32Of(file.data(), file.size()));
    putSection(file, kHeadTag, head);
    putSection(file, kOptionsTag, options);
    putSection(file, kCellsTag, cells);
    writeFileAtomically(path, {reinterpret_cast<const char*>(file.data()), file.size()});
}

std::optional<std::uint64_t> mapBytesOfEnvironment() {
    constexpr std::uint64_t kMebi = std::uint64_t{1} << 20;
    const char* text = std::getenv("SUPERRAY_MAP_MEGABYTES");
    if (text == nullptr) return std::nullopt;
    std::uint64_t mebibytes = 0;
    const char* end = text + std::strlen(text);
    const auto parsed = std::from_chars(text, end, mebibytes);
    if (parsed.ec != std::errc() || parsed.ptr != end || mebibytes >= (kMebi << 20))
        return std::nullopt;
    return mebibytes * kMebi;
}

MapFileLimits MapFileLimits::ofThisMachine() {
    const std::uint64_t half = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / 2;
    const std::uint64_t bytes = mapBytesOfEnvironment().value_or(half);
    return {bytes, bytes};
}

MapFile loadMapFile(const std::string& path, const MapFileLimits& limits) {
    const Bytes bytes = readWholeFile(
        path, kPreamble, limits.fileBytes, [&](const Bytes& start, std::uint64_t size) {
            SectionReader(start.data(), size, path).readPreamble();
        });
    return parseMapFile(bytes.data(), bytes.size(), path);
}

MapFile parseMapFile(const std::uint8_t* data, std::size_t size, const std::string& name) {
    return SectionReader(data, size, name).read();
}

}  // namespace superray
