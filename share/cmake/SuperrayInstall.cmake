# SPDX-License-Identifier: BSD-3-Clause
# find_package(superray [COMPONENTS core storage maps eval slam]).
include(CMakePackageConfigHelpers)
set(superray_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/superray)

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/superray-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/superray-config.cmake
  INSTALL_DESTINATION ${superray_cmake_dir})
write_basic_package_version_file(
  ${CMAKE_CURRENT_BINARY_DIR}/superray-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT superray-targets NAMESPACE superray:: DESTINATION ${superray_cmake_dir}
        COMPONENT dev)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/superray-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/superray-config-version.cmake
        DESTINATION ${superray_cmake_dir} COMPONENT dev)
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/share/config_files/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/superray/config_files
        COMPONENT runtime)
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/share/examples/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/superray/examples COMPONENT doc)

# Installed anywhere, the programs find the library beside them.
file(RELATIVE_PATH superray_bin_to_lib ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
if(SUPERRAY_BUILD_APPS)
  set_target_properties(superray-map superray-bench superray-slam-app
                        PROPERTIES INSTALL_RPATH "\$ORIGIN/${superray_bin_to_lib}")
endif()
