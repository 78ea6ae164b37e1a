// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file grow.h
/// Room in lists, for the libraries of this project; no public interface.

#include <algorithm>
#include <cstddef>

namespace superray::detail {

/// Makes sure that so many elements can be appended to a vector without failure. Like
/// appending them one by one, it takes little time if it is done again and again.
/// \throws std::bad_alloc, std::length_error
template <typename Vector>
void growBy(Vector& list, std::size_t more) {
    if (list.capacity() - list.size() < more)
        list.reserve(std::max(2 * list.capacity(), list.size() + more));
}

}  // namespace superray::detail
