# SPDX-License-Identifier: BSD-3-Clause
# superray_zstd: the installed libzstd. Its own package file exists on some Debian
# releases only, and names its targets differently in others.
find_path(ZSTD_INCLUDE_DIR zstd.h)
find_library(ZSTD_LIBRARY zstd)
mark_as_advanced(ZSTD_INCLUDE_DIR ZSTD_LIBRARY)
if(NOT ZSTD_INCLUDE_DIR OR NOT ZSTD_LIBRARY)
  message(FATAL_ERROR "zstd is missing: apt install libzstd-dev")
endif()
add_library(superray_zstd INTERFACE IMPORTED)
set_target_properties(
  superray_zstd PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ZSTD_INCLUDE_DIR}"
                           INTERFACE_LINK_LIBRARIES "${ZSTD_LIBRARY}")
