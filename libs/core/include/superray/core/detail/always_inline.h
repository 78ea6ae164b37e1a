// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// For the small steps of a kernel: what they share stays in registers.
#define SUPERRAY_INLINE inline __attribute__((always_inline))
