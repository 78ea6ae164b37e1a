// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sanitizers.h
/// Whether this is compiled with a sanitizer: GCC and clang say it in two ways.
/// SUPERRAY_ADDRESS_SANITIZER and SUPERRAY_THREAD_SANITIZER are 0 or 1.

#ifdef __has_feature
#define SUPERRAY_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#define SUPERRAY_THREAD_SANITIZER __has_feature(thread_sanitizer)
#else
#ifdef __SANITIZE_ADDRESS__
#define SUPERRAY_ADDRESS_SANITIZER 1
#else
#define SUPERRAY_ADDRESS_SANITIZER 0
#endif
#ifdef __SANITIZE_THREAD__
#define SUPERRAY_THREAD_SANITIZER 1
#else
#define SUPERRAY_THREAD_SANITIZER 0
#endif
#endif

namespace superray {

/// These reserve terabytes of addresses, so that they cannot be limited, and keep freed memory.
inline constexpr bool kSanitized = SUPERRAY_ADDRESS_SANITIZER || SUPERRAY_THREAD_SANITIZER;

}  // namespace superray
