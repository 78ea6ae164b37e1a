# One executable per header of libs/slam; the command line has its own.
foreach(name trajectory_error slam_options scan_registration range_slam)
  superray_add_test(slam_${name}_test SOURCES slam/${name}_test.cpp LIBS superray::slam)
  target_compile_definitions(
    slam_${name}_test
    PRIVATE SUPERRAY_CONFIG_FILES_DIR="${PROJECT_SOURCE_DIR}/share/config_files")
endforeach()
foreach(name slam_cli sequences)
  superray_add_test(slam_${name}_test SOURCES slam/${name}_test.cpp LIBS superray::slam)
  target_compile_definitions(
    slam_${name}_test
    PRIVATE SUPERRAY_SLAM_APP="$<TARGET_FILE:superray-slam-app>"
            SUPERRAY_CONFIG_FILES_DIR="${PROJECT_SOURCE_DIR}/share/config_files")
  add_dependencies(slam_${name}_test superray-slam-app)
endforeach()
