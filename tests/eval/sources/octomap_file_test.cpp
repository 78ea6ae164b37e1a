// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>
#include <superray/eval/input_error.h>
#include <superray/eval/octomap_file.h>

#include <algorithm>
#include <random>

#include "eval/temp_folder.h"

namespace superray {
namespace {

using test::messageOf;
using test::readWholeFile;
using test::TempFolder;

/// Random cells, and a block of equal ones that pruning turns into large leaves.
octomap::OcTree makeTree(unsigned seed) {
    octomap::OcTree tree(0.25);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> coordinate(-40, 40);
    std::uniform_real_distribution<float> value(-2.0f, 3.5f);
    const auto key = [](int cell) { return static_cast<octomap::key_type>(32768 + cell); };
    for (int i = 0; i < 500; ++i)
        tree.setNodeValue(octomap::OcTreeKey(key(coordinate(random)), key(coordinate(random)),
                                             key(coordinate(random))),
                          value(random), true);
    for (int x = 64; x < 80; ++x)
        for (int y = -16; y < 0; ++y)
            for (int z = 0; z < 16; ++z)
                tree.setNodeValue(octomap::OcTreeKey(key(x), key(y), key(z)), -2.0f, true);
    tree.updateInnerOccupancy();
    tree.prune();
    return tree;
}

std::uint64_t countKnown(const OccupancyMap<3>& map) {
    std::uint64_t known = 0;
    map.forEachBlock(
        [&](const BlockView<3>& b) { known += static_cast<std::uint64_t>(b.known.count()); });
    return known;
}

/// Calls `visit(cell, leaf value)` for every cell of a tree at full depth.
template <class Visit>
std::uint64_t forEachCell(octomap::OcTree tree, const Visit& visit) {
    tree.expand();
    std::uint64_t cells = 0;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, ++cells) {
        const auto key = leaf.getKey();
        visit(Cell<3>{key[0] - 32768, key[1] - 32768, key[2] - 32768}, leaf->getLogOdds());
    }
    return cells;
}

TEST(OctomapFile, readsLogOddsAsOctomapWroteThem) {
    TempFolder folder;
    const auto tree = makeTree(1);
    ASSERT_TRUE(tree.write(folder / "a.ot"));
    const auto file = readOctomapFile(folder / "a.ot");
    EXPECT_EQ(file.values, CellValues::logOdds);
    EXPECT_EQ(file.map->geometry().resolution(), 0.25);
    const auto cells = forEachCell(tree, [&](const Cell<3>& cell, float value) {
        EXPECT_EQ(file.map->logOdds(cell), value);
    });
    EXPECT_GT(cells, 4500u);
    EXPECT_EQ(countKnown(*file.map), cells);
}

TEST(OctomapFile, readsOccupancyAsOctomapWroteIt) {
    TempFolder folder;
    auto tree = makeTree(2);
    ASSERT_TRUE(tree.writeBinary(folder / "a.bt"));  // makes the tree maximum likelihood
    const auto file = readOctomapFile(folder / "a.bt");
    EXPECT_EQ(file.values, CellValues::occupancy);
    std::uint64_t occupied = 0;
    const auto cells = forEachCell(tree, [&](const Cell<3>& cell, float value) {
        EXPECT_EQ(file.map->logOdds(cell), value >= 0 ? 1.0f : -1.0f);
        occupied += value >= 0;
    });
    EXPECT_GT(cells, 4500u);
    EXPECT_GT(occupied, 100u);
    EXPECT_EQ(countKnown(*file.map), cells);
}

TEST(OctomapFile, readsAnEmptyTree) {
    TempFolder folder;
    ASSERT_TRUE(octomap::OcTree(0.5).write(folder / "a.ot"));
    EXPECT_TRUE(readOctomapFile(folder / "a.ot").map->empty());
}

TEST(OctomapFile, refusesEveryPrefix) {
    TempFolder folder;
    auto tree = makeTree(3);
    ASSERT_TRUE(tree.write(folder / "a.ot"));
    ASSERT_TRUE(tree.writeBinary(folder / "a.bt"));
    int cases = 0;
    for (const char* name : {"a.ot", "a.bt"}) {
        const auto whole = readWholeFile(folder / name);
        for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 97) {
            const auto path = folder.write("cut", whole.substr(0, length));
            EXPECT_THROW(readOctomapFile(path), InputError) << name << " " << length;
            ++cases;
        }
        EXPECT_THROW(readOctomapFile(folder.write("long", whole + "x")), InputError);
    }
    EXPECT_GE(cases, 180);
}

TEST(OctomapFile, survivesDamage) {
    TempFolder folder;
    auto tree = makeTree(4);
    ASSERT_TRUE(tree.write(folder / "a.ot"));
    ASSERT_TRUE(tree.writeBinary(folder / "a.bt"));
    std::mt19937 random(7);
    int cases = 0, refused = 0;
    for (const char* name : {"a.ot", "a.bt"}) {
        const auto whole = readWholeFile(folder / name);
        for (int i = 0; i < 300; ++i, ++cases) {
            std::string damaged = whole;
            for (int k = 0; k < 3; ++k)
                damaged[random() % damaged.size()] = static_cast<char>(random());
            const auto path = folder.write("damaged", damaged);
            refused += messageOf<InputError>([&] { readOctomapFile(path); }) != "no exception";
        }
    }
    EXPECT_EQ(cases, 600);
    EXPECT_GT(refused, 100);
}

TEST(OctomapFile, saysWhatIsWrong) {
    TempFolder folder;
    const std::string magic = "# Octomap OcTree file\n";
    struct Case {
        std::string contents;
        const char* expected;
    };
    std::string deep = magic + "id OcTree\nsize 99999\nres 0.1\ndata\n";
    for (int i = 0; i < 40; ++i) deep += std::string("\0\0\0\0\1", 5);  // one child each
    std::string vast = magic + "id OcTree\nsize 1\nres 0.1\ndata\n" + std::string(5, '\0');
    std::string nan = magic + "id OcTree\nsize 1\nres 0.1\ndata\n" + std::string(2, '\0') +
                      std::string("\xc0\x7f", 2) + std::string(1, '\0');
    const Case cases[] = {
        {"", "first line"},
        {"hello\n", "first line"},
        {magic, "no line 'data'"},
        {magic + "id OcTreeStamped\nsize 0\nres 0.1\ndata\n", "'OcTreeStamped'"},
        {magic + "id OcTree\nsize x\nres 0.1\ndata\n", "size x"},
        {magic + "id OcTree\nsize 0\nres 0\ndata\n", "resolution"},
        {magic + "id OcTree\nsize 0\nres -1\ndata\n", "resolution"},
        {magic + "id OcTree\nsize 0\nres 1e-300\ndata\n", "from 1e-6 to 1e6 m"},
        {magic + "id OcTree\nsize 0\nres 1e7\ndata\n", "from 1e-6 to 1e6 m"},
        {magic + "id OcTree\nsize 0\nres nan\ndata\n", "res"},
        {magic + "id OcTree\nsize 2\nres 0.1\ndata\n", "ends early"},
        {deep, "deeper than 16"},
        {vast, "pruned nodes stand for more than"},
        {nan, "not finite"},
    };
    for (const auto& c : cases) {
        const auto path = folder.write("bad.ot", c.contents);
        const auto message = messageOf<InputError>([&] { readOctomapFile(path); });
        EXPECT_NE(message.find(c.expected), std::string::npos) << c.expected << ": " << message;
        EXPECT_NE(message.find("bad.ot"), std::string::npos) << message;
    }
    EXPECT_THROW(readOctomapFile(folder / "absent.ot"), InputError);
    EXPECT_THROW(readOctomapFile(folder / "."), InputError);
}

}  // namespace
}  // namespace superray
