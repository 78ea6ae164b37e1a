superray_add_test(system_octomap_agreement_test SOURCES system/octomap_agreement_test.cpp
                  LIBS superray::eval superray::storage octomap)

# Stock MRPT programs with the plugin, and projects that use the installation.
# A program that was not built with a sanitizer cannot load a plugin that was.
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  message(STATUS "Sanitizers are on: stock MRPT programs are NOT TESTED with the plugin")
else()
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  foreach(name icp_slam particle_filters observations2map rawlog_edit viewers sensor_examples install
               benchmark_tables)
    add_test(NAME system_${name}
             COMMAND ${Python3_EXECUTABLE} -B
                     ${CMAKE_CURRENT_SOURCE_DIR}/system/${name}_test.py -v)
    set_tests_properties(
      system_${name}
      PROPERTIES TIMEOUT 300
                 ENVIRONMENT
                 "SUPERRAY_MAP=$<TARGET_FILE:superray-map>;SUPERRAY_BENCH=$<TARGET_FILE:superray-bench>;SUPERRAY_PLUGIN=$<TARGET_FILE:superray-maps>;SUPERRAY_SOURCE_DIR=${PROJECT_SOURCE_DIR};SUPERRAY_BUILD_DIR=${PROJECT_BINARY_DIR}")
  endforeach()
endif()
