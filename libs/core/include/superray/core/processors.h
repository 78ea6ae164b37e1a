// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file processors.h

#include <thread>

#ifdef __linux__
#include <sched.h>
#endif

namespace superray {

/// Number of processors that this process may run on, >= 1.
///
/// std::thread::hardware_concurrency() does not promise to honour what taskset or a
/// batch system allows.
inline unsigned availableProcessors() {
#ifdef __linux__
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) {
        const int count = CPU_COUNT(&allowed);
        if (count > 0) return static_cast<unsigned>(count);
    }
#endif
    const unsigned all = std::thread::hardware_concurrency();
    return all > 0 ? all : 1;
}

}  // namespace superray
