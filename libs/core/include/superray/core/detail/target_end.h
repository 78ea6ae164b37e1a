// SPDX-License-Identifier: BSD-3-Clause
// Ends what target_begin.h began. No include guard.

#ifndef SUPERRAY_IN_TARGET_REGION
#error "target_begin.h is missing"
#endif
#undef SUPERRAY_IN_TARGET_REGION

#if defined(SUPERRAY_TARGET_AVX512) || defined(SUPERRAY_TARGET_AVX2)
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
