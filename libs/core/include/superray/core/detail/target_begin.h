// SPDX-License-Identifier: BSD-3-Clause
// No include guard: each file with vector code includes this before its
// functions, and target_end.h after them. Between the two, functions are
// compiled for the instruction set that the .cpp file names before its first
// #include:
//     #define SUPERRAY_TARGET_AVX2   or   #define SUPERRAY_TARGET_AVX512
// or, with neither, for what the compiler's options say.
//
// What stands between must be in an unnamed namespace. Several .cpp files
// include the same templates for different sets; if these had external linkage,
// the linker would keep one of the copies for all of them, and a processor
// might meet instructions that it lacks. For the same reason, all #includes
// come before target_begin.h.

#ifdef SUPERRAY_IN_TARGET_REGION
#error "target_end.h is missing, or an #include is between target_begin.h and target_end.h"
#endif
#define SUPERRAY_IN_TARGET_REGION

#if defined(SUPERRAY_TARGET_AVX512) && defined(__clang__)
#pragma clang attribute push( \
    __attribute__((target("avx2,avx512f,avx512vl,avx512dq,avx512bw"))), apply_to = function)
#elif defined(SUPERRAY_TARGET_AVX512)
#pragma GCC push_options
#pragma GCC target("avx2,avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512")
#elif defined(SUPERRAY_TARGET_AVX2) && defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#elif defined(SUPERRAY_TARGET_AVX2)
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
