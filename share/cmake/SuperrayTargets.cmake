# SPDX-License-Identifier: BSD-3-Clause
# Shared settings of this project's targets: strict warnings and bit-exact
# floating point, both PRIVATE so that users' builds are untouched.

function(superray_target_settings target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF
                                             POSITION_INDEPENDENT_CODE ON)
  target_compile_options(
    ${target}
    PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor
            -Woverloaded-virtual
            # Part of clang's -Wconversion, not of GCC's.
            -Wno-sign-conversion
            # Same bits from every instruction set: no silent fused multiply-add.
            -ffp-contract=off)
  # Headers of MRPT 2.14 and 2.15 (lock_helper.h, bonxai.hpp) have members of templates that
  # cannot be compiled, and that nothing calls. From 19 on, clang would look at them.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 19)
    target_compile_options(${target} PRIVATE -fdelayed-template-parsing)
  endif()
  if(SUPERRAY_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# superray_add_library(<name> SOURCES ...): libsuperray-<name>, superray::<name>.
function(superray_add_library name)
  cmake_parse_arguments(arg "" "TYPE" "SOURCES" ${ARGN})
  if(NOT arg_TYPE)
    set(arg_TYPE STATIC)
  endif()
  set(target superray-${name})
  add_library(${target} ${arg_TYPE} ${arg_SOURCES})
  add_library(superray::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(
    ${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                     $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
              PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  superray_target_settings(${target})
  install(TARGETS ${target} EXPORT superray-targets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
endfunction()
