// SPDX-License-Identifier: BSD-3-Clause
#include "directions/packed_triple.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/ray_generators.h"

namespace superray {
namespace {

using test::Random;

TEST(PackedTriple, ComparesAndJoinsAxisByAxis) {
    Random random(77);
    int within = 0;
    for (int i = 0; i < 2000; ++i) {
        std::int32_t a[3], b[3];
        PackedTriple ea{}, eb{};
        bool expected = true;
        for (int axis = 0; axis < 3; ++axis) {
            const int most = test::integer(random, 0, 1) ? 65535 : 3;
            a[axis] = test::integer(random, 0, most);
            b[axis] = test::integer(random, 0, most);
            ea.set(axis, a[axis]);
            eb.set(axis, b[axis]);
            expected &= a[axis] <= b[axis];
        }
        ASSERT_EQ(ea.within(eb), expected);
        within += expected;
        for (unsigned axis = 0; axis < 3; ++axis) {
            ASSERT_EQ(ea[axis], a[axis]);
            ASSERT_EQ(ea.joined(eb)[axis], std::max(a[axis], b[axis]));
        }
    }
    EXPECT_GT(within, 200);
    EXPECT_LT(within, 1000);
}

}  // namespace
}  // namespace superray
