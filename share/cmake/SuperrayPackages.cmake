# SPDX-License-Identifier: BSD-3-Clause
# Debian packages (share/scripts/package.sh builds them):
#   superray         the plugin, the programs, their man pages, configuration files
#   libsuperray-dev  headers, static libraries, find_package(superray)
#   superray-doc     documentation and examples
# The plugin's name without a number is in `superray`, not in -dev: stock MRPT programs
# load it by that name.
option(SUPERRAY_BUILD_MAN "Make man pages (needs help2man)" OFF)
if(SUPERRAY_BUILD_MAN)
  find_program(HELP2MAN help2man REQUIRED)
  find_program(GZIP gzip REQUIRED)
  set(superray_man_pages)
  # man_page(<target> <program> <one line>)
  function(man_page target program line)
    set(page ${CMAKE_CURRENT_BINARY_DIR}/man/${program}.1)
    add_custom_command(
      OUTPUT ${page}.gz
      COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_CURRENT_BINARY_DIR}/man
      COMMAND ${HELP2MAN} --no-info --name=${line} --output=${page} $<TARGET_FILE:${target}>
      COMMAND ${GZIP} --force --best --no-name ${page}
      DEPENDS ${target}
      VERBATIM)
    set(superray_man_pages ${superray_man_pages} ${page}.gz PARENT_SCOPE)
  endfunction()
  man_page(superray-map superray-map "make occupancy maps from recorded scans")
  man_page(superray-bench superray-bench "time occupancy mappers on recorded scans")
  man_page(superray-slam-app superray-slam "trajectory and map from scans without poses")
  add_custom_target(superray-man ALL DEPENDS ${superray_man_pages})
  install(FILES ${superray_man_pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime)
endif()

install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/superray-doc
        COMPONENT doc)
install(DIRECTORY doc/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/superray-doc/doc COMPONENT doc)
foreach(pair runtime:superray dev:libsuperray-dev doc:superray-doc)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 component)
  list(GET pair 1 package)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME copyright
          COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL runtime dev doc)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGE_NAME superray)
set(CPACK_PACKAGE_CONTACT "superray maintainers <superray@localhost>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)
# MRPT's libraries are named after its version: one build per release of Debian.
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release superray_release REGEX "^VERSION_ID=")
  string(REGEX REPLACE "[^0-9]" "" superray_release "${superray_release}")
endif()
if(superray_release)
  set(CPACK_DEBIAN_PACKAGE_RELEASE "1~deb${superray_release}")
else()
  set(CPACK_DEBIAN_PACKAGE_RELEASE "1~sid")
endif()
set(superray_package_version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME superray)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS mrpt-apps)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS superray-doc)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "Plugin for stock MRPT programs, and programs that make occupancy maps in 2D and\n3D from recordings, updated by super rays and culling regions.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsuperray-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "superray (= ${superray_package_version}), libbz2-dev, libeigen3-dev, liblz4-dev, libmrpt-dev, liboctomap-dev, libpng-dev, libsqlite3-dev, libtbb-dev, libzstd-dev, zlib1g-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "Development files: headers, static libraries and the CMake package superray.")
set(CPACK_DEBIAN_DOC_PACKAGE_NAME superray-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_COMPONENT_DOC_DESCRIPTION
    "Documentation: what the maps are, how they are used and measured; examples.")
include(CPack)
