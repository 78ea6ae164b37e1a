foreach(name options range_image_returns velodyne_returns other_returns insertion
        serialization registration views voxel_view points_map likelihood distance_field
        localization shared_storage
        deskew octomap_defects map_queries map_algebra matching)
  superray_add_test(maps_${name}_test SOURCES maps/${name}_test.cpp LIBS superray::maps)
endforeach()
target_link_libraries(maps_views_test PRIVATE octomap)
target_link_libraries(maps_octomap_defects_test PRIVATE octomap)
target_link_libraries(maps_map_queries_test PRIVATE octomap)
target_include_directories(maps_voxel_view_test PRIVATE ${PROJECT_SOURCE_DIR}/libs/maps/src)
target_compile_definitions(
  maps_registration_test
  PRIVATE SUPERRAY_CONFIG_FILES_DIR="${PROJECT_SOURCE_DIR}/share/config_files")
# The field is no part of the interface.
target_include_directories(maps_distance_field_test PRIVATE ${PROJECT_SOURCE_DIR}/libs/maps/src)
