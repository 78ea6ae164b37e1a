// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <type_traits>

namespace superray::test {

/// For tests of what exists in 2D and in 3D.
using Dims = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;

}  // namespace superray::test
