// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What GCC and clang spell differently.

/// Before a loop: no iteration reads what another one writes.
#if defined(__clang__)
#define SUPERRAY_INDEPENDENT_ITERATIONS _Pragma("clang loop vectorize(assume_safety)")
#else
#define SUPERRAY_INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif
