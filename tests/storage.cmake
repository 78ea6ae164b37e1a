superray_add_test(storage_occupancy_map_test SOURCES storage/occupancy_map_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_content_digest_test SOURCES storage/content_digest_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_octree_test SOURCES storage/octree_test.cpp
                  LIBS superray::storage octomap)
superray_add_test(storage_fold_layers_test SOURCES storage/fold_layers_test.cpp
                  LIBS superray::storage)
# Internal headers: the inner loop has versions that only some CPUs run.
target_include_directories(storage_fold_layers_test
                           PRIVATE ${PROJECT_SOURCE_DIR}/libs/storage/src)
superray_add_test(storage_map_file_test SOURCES storage/map_file_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
superray_add_test(storage_map_file_fuzz_test SOURCES storage/map_file_fuzz_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
superray_add_test(storage_map_file_versions_test SOURCES storage/map_file_versions_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
