// SPDX-License-Identifier: BSD-3-Clause
// Broken files, thousands of them: an error or the right map, never a crash,
// and never a map that is half replaced.

#include "storage/file/map_file_tools.h"

namespace superray::test {
namespace {

constexpr int kMutations = 4000;

/// One to four random changes: bits, bytes, cuts, insertions, exchanged parts.
Bytes mutated(Bytes bytes, std::mt19937& random) {
    const auto at = [&] { return static_cast<std::ptrdiff_t>(random() % bytes.size()); };
    for (unsigned n = random() % 4 + 1; n > 0 && !bytes.empty(); --n) {
        auto position = bytes.begin() + at();
        switch (random() % 6) {
            case 0:
                *position = static_cast<std::uint8_t>(*position ^ (1u << (random() % 8)));
                break;
            case 1:
                *position = static_cast<std::uint8_t>(random());
                break;
            case 2:
                bytes.erase(position, bytes.end());
                break;
            case 3:
                bytes.insert(position, random() % 9 + 1, static_cast<std::uint8_t>(random()));
                break;
            case 4:
                for (int i = 0; i < 8 && position != bytes.end(); ++i, ++position)
                    *position = random() % 2 ? 0xFF : 0;
                break;
            default:
                std::iter_swap(position, bytes.begin() + at());
        }
    }
    return bytes;
}

class MapFileFuzz : public ::testing::Test {
 protected:
    BlockGrid<3> map{CellGeometry<3>(0.05)};
    Octree target{CellGeometry<3>(0.05)};
    Bytes cells, file;
    std::string mapDigest, targetDigest;
    std::mt19937 random{99};

    MapFileFuzz() {
        fillRandomly<3>(map, 5);
        cells = encodeCells<3>(map);
        file = fileOf(cells);
        mapDigest = contentDigest<3>(map);
        target.setLogOdds({1, 2, 3}, 0.5f);
        targetDigest = contentDigest<3>(target);
    }
    Bytes fileOf(const Bytes& cellBytes) const {
        TemporaryFolder folder;
        saveMapFile(folder.path + "/m", {"CSuperRayGridMap3D", 3, 0.05, "a = b\n"}, cellBytes);
        return contentsOf(folder.path + "/m");
    }
    /// \return whether the cells were accepted; if not, the map is untouched
    bool decodes(const Bytes& bytes) {
        try {
            decodeCells<3>(bytes.data(), bytes.size(), target);
            return true;
        } catch (const MapFileError&) {
            EXPECT_EQ(contentDigest<3>(target), targetDigest) << "refused, yet replaced";
            return false;
        }
    }
};

TEST_F(MapFileFuzz, UnchangedFileLoads) {
    const MapFile loaded = parseMapFile(file.data(), file.size(), "x");
    ASSERT_TRUE(decodes(loaded.cells));
    EXPECT_EQ(contentDigest<3>(target), mapDigest);
}

TEST_F(MapFileFuzz, MutatedFilesAreRefused) {
    int changed = 0;
    for (int i = 0; i < kMutations; ++i) {
        const Bytes bytes = mutated(file, random);
        if (bytes == file) continue;
        ++changed;
        EXPECT_THROW(parseMapFile(bytes.data(), bytes.size(), "x"), MapFileError);
    }
    EXPECT_GT(changed, kMutations * 9 / 10);
}

TEST_F(MapFileFuzz, EveryTruncationIsRefused) {
    for (std::size_t size = 0; size < file.size(); size += size < 400 ? 1 : 37) {
        const Bytes bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_THROW(parseMapFile(bytes.data(), bytes.size(), "x"), MapFileError) << size;
    }
    for (std::size_t size = 0; size < cells.size(); size += size < 400 ? 1 : 37)
        EXPECT_FALSE(
            decodes(Bytes(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(size))));
}

TEST_F(MapFileFuzz, MutatedSectionsWithRightChecksums) {
    int accepted = 0;
    for (int i = 0; i < kMutations; ++i) {
        Sections sections = sectionsOf(file);
        auto& data = sections[random() % 3].second;
        data = mutated(data, random);
        const Bytes bytes = containerOf(sections);
        try {
            const MapFile parsed = parseMapFile(bytes.data(), bytes.size(), "x");
            if (parsed.cells == cells)
                ++accepted;  // options and class name are any text
            else
                EXPECT_FALSE(decodes(parsed.cells)) << "the cells have a checksum of their own";
        } catch (const MapFileError&) {
        }
    }
    EXPECT_GT(accepted, kMutations / 10);
}

TEST_F(MapFileFuzz, MutatedCellsWithRightChecksums) {
    int accepted = 0, refused = 0;
    for (int i = 0; i < kMutations; ++i) {
        OpenCells open(cells);
        if (random() % 4 == 0)
            open.header = mutated(open.header, random);
        else
            open.raw = mutated(open.raw, random);
        open.header.resize(48);
        if (!decodes(open.close())) {
            ++refused;
            continue;
        }
        ++accepted;  // e.g. one value changed: a valid map, whole
        targetDigest = contentDigest<3>(target);
        for (const auto& [cell, value] : cellsOf<3>(target)) {
            ASSERT_TRUE(std::isfinite(value));
            ASSERT_GE(cell[0], -kCellLimit);
            ASSERT_LT(cell[0], kCellLimit);
        }
    }
    EXPECT_GT(accepted, kMutations / 20);
    EXPECT_GT(refused, kMutations / 4);
}

// One broken rule at a time, everything else right.
TEST_F(MapFileFuzz, EachRuleOfTheCells) {
    const OpenCells good(cells);
    ASSERT_EQ(good.close().size(), cells.size());
    const auto refused = [&](std::size_t headerAt, std::uint64_t value, int bytes) {
        OpenCells open = good;
        open.setHeaderNumber(headerAt, value, bytes);
        return !decodes(open.close());
    };
    EXPECT_TRUE(refused(0, 2, 4)) << "version";
    EXPECT_TRUE(refused(4, 2, 1)) << "dimension";
    EXPECT_TRUE(refused(5, 1, 1)) << "reserved byte";
    EXPECT_TRUE(refused(8, 0x7FF8000000000000ull, 8)) << "resolution";
    const std::uint64_t blocks = numberAt(cells, 16, 8), known = numberAt(cells, 24, 8);
    EXPECT_TRUE(refused(16, blocks - 1, 8)) << "fewer blocks";
    EXPECT_TRUE(refused(16, blocks + 1, 8)) << "more blocks";
    EXPECT_TRUE(refused(16, ~0ull, 8)) << "absurd number of blocks";
    EXPECT_TRUE(refused(24, known + 1, 8)) << "known cells";

    const auto rawRefused = [&](const std::vector<std::uint8_t>& raw, std::uint64_t blockCount,
                                std::uint64_t cellCount) {
        OpenCells open = good;
        open.raw = raw;
        open.setHeaderNumber(16, blockCount, 8);
        open.setHeaderNumber(24, cellCount, 8);
        return !decodes(open.close());
    };
    const auto uniform = [](std::int32_t x, std::uint8_t kind, std::uint32_t valueBits) {
        Bytes raw;
        putNumber(raw, static_cast<std::uint32_t>(x), 4);
        putNumber(raw, 0, 8);
        raw.push_back(kind);
        putNumber(raw, valueBits, 4);
        return raw;
    };
    const auto joined = [](Bytes a, const Bytes& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    const std::uint32_t one = bitsOf(1.0f);
    EXPECT_FALSE(rawRefused(uniform(0, 1, one), 1, 512)) << "a good one, for comparison";
    targetDigest = contentDigest<3>(target);
    EXPECT_TRUE(rawRefused(uniform(0, 2, one), 1, 512)) << "kind";
    EXPECT_TRUE(rawRefused(uniform(4096, 1, one), 1, 512)) << "block beyond the limit";
    EXPECT_TRUE(rawRefused(uniform(-4097, 1, one), 1, 512)) << "block beyond the limit";
    EXPECT_TRUE(rawRefused(uniform(0, 1, 0x7F800000u), 1, 512)) << "infinite";
    EXPECT_TRUE(rawRefused(uniform(0, 1, 0x7FC00000u), 1, 512)) << "NaN";
    EXPECT_TRUE(rawRefused(joined(uniform(0, 1, one), uniform(0, 1, one)), 2, 1024)) << "twice";
    EXPECT_TRUE(rawRefused(joined(uniform(1, 1, one), uniform(0, 1, one)), 2, 1024)) << "order";
    EXPECT_TRUE(rawRefused(joined(uniform(0, 1, one), {0}), 1, 512)) << "bytes left over";
    Bytes nothingKnown = uniform(0, 0, 0);
    nothingKnown.resize(13 + 64);
    EXPECT_TRUE(rawRefused(nothingKnown, 1, 0)) << "mixed block without known cells";
}

// A small file that claims to be huge must not take memory first.
TEST_F(MapFileFuzz, ImpossibleLengthIsRefusedBeforeInflating) {
    OpenCells open(cells);
    Bytes bytes = open.close();
    const std::uint64_t deflated = bytes.size() - 52;
    for (const std::uint64_t claimed : {deflated * 2000, std::uint64_t{1} << 62}) {
        for (int i = 0; i < 8; ++i)
            bytes[32 + static_cast<std::size_t>(i)] =
                static_cast<std::uint8_t>(claimed >> (8 * i));
        Bytes checked(bytes.begin(), bytes.begin() + 48);
        checked.insert(checked.end(), bytes.begin() + 52, bytes.end());
        const std::uint32_t crc = crcOf(checked, 0, checked.size());
        for (int i = 0; i < 4; ++i)
            bytes[48 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(crc >> (8 * i));
        EXPECT_FALSE(decodes(bytes));
        try {
            decodeCells<3>(bytes.data(), bytes.size(), target);
        } catch (const MapFileError& e) {
            EXPECT_NE(std::string(e.what()).find("impossible"), std::string::npos) << e.what();
        }
    }
}

}  // namespace
}  // namespace superray::test
